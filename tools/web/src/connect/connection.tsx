// SPDX-License-Identifier: MIT
// Connecting to a board, who it is, and leaving it.
import { useState } from "preact/hooks";
import type { LiveHead, Names } from "../core/protocol.ts";
import type { Board, Phase } from "./board.ts";
import { PortSetup } from "./port_setup.tsx";
import { connectionOf, FIRST_SETTINGS, type Settings } from "./settings.ts";
import { serialOf } from "./web_serial.ts";

const BUILD_SHOWN = 12; // hexadecimal digits

let settings: Settings = FIRST_SETTINGS; // kept while another part of the bench is open

// Nothing where a person chooses none.
async function connect(board: Board): Promise<void> {
    const connection = connectionOf(settings);
    try {
        const port = await serialOf(navigator)?.requestPort();
        if (port !== undefined) {
            void board.connect(port, connection);
        }
    } catch (error) {
        if ((error as DOMException).name !== "NotFoundError") {
            throw error;
        }
    }
}

function Head({ head }: { head: LiveHead }) {
    const { name, build, ticks_per_s: ticks, baud, baud_needed: needed } = head;
    return (
        <>
            <p class="board-name" role="status">
                <strong>{name}</strong>
                {`, build ${build.slice(0, BUILD_SHOWN)}, ${Math.round(ticks)} ticks/s`}
            </p>
            {baud !== 0 && baud < needed && (
                <p class="problem">{`The line is too slow for all ticks: ${baud} baud, ${needed} needed; there may be gaps.`}</p>
            )}
        </>
    );
}

// What the one button says and does.
const BUTTON: Record<Phase, string> = {
    away: "Connect", connecting: "Cancel", following: "Disconnect", leaving: "Cut the line",
};

export function Connection({ board, names }: { board: Board; names: Names }) {
    const [shown, setShown] = useState(settings);
    const [problem, setProblem] = useState("");
    const { phase, head, parting } = board;
    const press = (): void => {
        setProblem("");
        if (phase === "away") {
            connect(board).catch((error: Error) => setProblem(error.message));
        } else if (phase === "following") {
            void board.disconnect();
        } else {
            board.cut();
        }
    };
    const set = (next: Settings): void => {
        settings = next;
        setShown(next);
    };
    const why = problem || board.problem;
    return (
        <section class="controls" aria-label="Connection">
            {phase === "away" && <PortSetup names={names} settings={shown} setSettings={set} />}
            {head !== undefined && phase !== "away" && <Head head={head} />}
            <button type="button" class={phase === "away" ? "main" : ""} onClick={press}>{BUTTON[phase]}</button>
            {phase === "connecting" && <p class="note" role="status">Asks who is there…</p>}
            {phase === "leaving" && <p class="note" role="status">Leaves the board…</p>}
            {parting !== "" && <p class="note" role="status">{parting}</p>}
            {why !== "" && <p class="problem" role="alert">{why}</p>}
        </section>
    );
}
