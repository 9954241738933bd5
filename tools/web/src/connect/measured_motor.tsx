// SPDX-License-Identifier: MIT
// What a measurement has found, and what to do with it.
import { useState } from "preact/hooks";
import type { Measured, Said } from "../core/protocol.ts";
import { download } from "../parts/format.ts";
import type { Board } from "./board.ts";
import type { Measuring } from "./measuring.ts";

function Values({ measured }: { measured: Measured }) {
    return (
        <table class="measured">
            <caption>{measured.name}</caption>
            <thead>
                <tr>{["Value", "Measured", "±", "Unit"].map((title) => <th key={title} scope="col">{title}</th>)}</tr>
            </thead>
            <tbody>
                {measured.rows.map(({ title, value, bar, unit }) => (
                    <tr key={title}>
                        <th scope="row">{title}</th>
                        <td>{value}</td>
                        <td>{bar}</td>
                        <td>{unit}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

function Next({ board, measuring, measured }: { board: Board; measuring: Measuring; measured: Measured }) {
    const [answer, setAnswer] = useState<Said & { line: string }>();
    const isDisabled = board.phase !== "following";
    const { fileName } = measuring;
    const tell = async (line: string): Promise<void> => setAnswer({ line, ...await board.talk.execute(line) });
    const save = (): void => download(`${fileName}.toml`, new Blob([measured.file], { type: "application/toml" }));
    return (
        <>
            <div class="buttons" role="group" aria-label="What next">
                <button type="button" onClick={save}>{`Download ${fileName}.toml`}</button>
                <button
                    type="button" class="main" title="The measured motor becomes the configuration in force." disabled={isDisabled}
                    onClick={() => void tell(`adopt ${fileName}`)}
                >
                    Adopt
                </button>
                <button
                    type="button" title="The next start of the board has what is in force now." disabled={isDisabled}
                    onClick={() => void tell("store")}
                >
                    Store
                </button>
                <button type="button" onClick={() => measuring.again()}>Measure again</button>
            </div>
            {answer !== undefined && (
                <p class={answer.refused ? "problem" : "note"} role="status">{`${answer.line}: ${answer.text}`}</p>
            )}
        </>
    );
}

export function MeasuredMotor({ board, measuring }: { board: Board; measuring: Measuring }) {
    const { measured } = measuring;
    if (measured === undefined) {
        return null;
    }
    return (
        <section class="controls" aria-label="What was measured">
            <Next board={board} measuring={measuring} measured={measured} />
            {measuring.problem !== "" && <p class="problem" role="alert">{measuring.problem}</p>}
            <Values measured={measured} />
            {measured.remarks.map((remark) => <p key={remark} class="note">{remark}</p>)}
            <p class="note">95 of 100 true values lie within their bars.</p>
        </section>
    );
}
