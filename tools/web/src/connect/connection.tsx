// SPDX-License-Identifier: MIT
// Connecting to a board, who it is, and leaving it.
import { useState } from "preact/hooks";
import type { LiveHead } from "../core/protocol.ts";
import { useRefresh } from "../parts/use_refresh.ts";
import type { TabProps } from "../tab.ts";
import type { Board, Phase } from "./board.ts";
import { knownRates } from "./known_rates.ts";
import { Leave } from "./leave.tsx";
import { PortSetup } from "./port_setup.tsx";
import { connectionOf, FIRST_SETTINGS, type Settings } from "./settings.ts";
import { noteWhileFollowed } from "./time_out.ts";
import { serialOf } from "./web_serial.ts";

const BUILD_SHOWN = 12; // hexadecimal digits

let settings: Settings = FIRST_SETTINGS; // kept while another part of the bench is open

// Nothing where a person chooses none.
async function connect(board: Board, { client, names, schema }: TabProps): Promise<void> {
    const { baud, options } = connectionOf(settings);
    try {
        const port = await serialOf(navigator)?.requestPort();
        if (port !== undefined) {
            void board.connect(port, baud === undefined ? await knownRates(client, names, schema) : [baud], options);
        }
    } catch (error) {
        if ((error as DOMException).name !== "NotFoundError") {
            throw error;
        }
    }
}

function TimeOut({ board }: { board: Board }) {
    useRefresh();
    const note = noteWhileFollowed(board.timeoutS);
    return note === undefined ? null : <p class={note.isBad ? "problem" : "note"} role="note">{note.text}</p>;
}

function Head({ head, rate }: { head: LiveHead; rate: number }) {
    const { name, build, ticks_per_s: ticks, baud, baud_needed: needed } = head;
    return (
        <>
            <p class="board-name" role="status">
                <strong>{name}</strong>
                {`, build ${build.slice(0, BUILD_SHOWN)}, ${Math.round(ticks)} ticks/s, at ${rate} baud`}
            </p>
            {baud !== 0 && baud < needed && (
                <p class="problem">{`The line is too slow for all ticks: ${baud} baud, ${needed} needed; there may be gaps.`}</p>
            )}
        </>
    );
}

const UNDER_WAY: Partial<Record<Phase, string>> = {
    connecting: "Waiting for the board to answer",
    leaving: "Disconnecting…",
    closing: "Disconnecting…",
};

// The one that fits how things stand; while the port closes there is nothing to press.
function Buttons({ board, begin }: { board: Board; begin(): void }) {
    const cut = (): void => board.cut();
    switch (board.phase) {
        case "away":
            return <button type="button" class="main" onClick={begin}>Connect</button>;
        case "connecting":
            return <button type="button" onClick={cut}>Cancel</button>;
        case "following":
            return <Leave board={board} />;
        case "leaving":
            return (
                <div class="buttons" role="group" aria-label="While disconnecting">
                    <button type="button" onClick={() => void board.talk.stop()}>Stop</button>
                    <button type="button" onClick={cut}>Cut the line</button>
                </div>
            );
        case "closing":
            return null;
    }
}

export function Connection({ board, props }: { board: Board; props: TabProps }) {
    const [shown, setShown] = useState(settings);
    const [problem, setProblem] = useState("");
    const { phase, head, parting } = board;
    const begin = (): void => {
        setProblem("");
        connect(board, props).catch((error: Error) => setProblem(error.message));
    };
    const set = (next: Settings): void => {
        settings = next;
        setShown(next);
    };
    const underWay = UNDER_WAY[phase];
    const why = problem || board.problem;
    return (
        <section class="controls" aria-label="Connection">
            {phase === "away" && <PortSetup client={props.client} names={props.names} settings={shown} setSettings={set} />}
            {head !== undefined && phase !== "away" && <Head head={head} rate={board.baud} />}
            {phase === "following" && <TimeOut board={board} />}
            <Buttons board={board} begin={begin} />
            {underWay !== undefined && <p class="note" role="status">{phase === "connecting" ? `${underWay} at ${board.baud} baud…` : underWay}</p>}
            {parting !== "" && <p class="note" role="status">{parting}</p>}
            {why !== "" && <p class="problem" role="alert">{why}</p>}
        </section>
    );
}
