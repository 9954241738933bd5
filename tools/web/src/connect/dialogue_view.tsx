// SPDX-License-Identifier: MIT
// A command line to the board, and what was said.
import { useId } from "preact/hooks";
import { type CommandHistory, useCommandHistory } from "../parts/command_history.ts";
import { SaidLog } from "../parts/said_log.tsx";
import type { Board } from "./board.ts";
import type { Line } from "./dialogue.ts";

function LineView({ line: { kind, text } }: { line: Line }) {
    if (kind === "asked") {
        return <div><code>{`> ${text}`}</code></div>;
    }
    return <pre class={kind === "refusal" ? "problem" : ""}>{text}</pre>;
}

function onKey(event: KeyboardEvent, history: CommandHistory, execute: (line: string) => void): void {
    const line = history.text.trim();
    const acts: Record<string, () => void> = {
        Enter: () => {
            if (line !== "") {
                history.keep(line);
                execute(line);
            }
        },
        ArrowUp: () => history.recall(-1),
        ArrowDown: () => history.recall(1),
    };
    const act = acts[event.key];
    if (act !== undefined) {
        event.preventDefault();
        act();
    }
}

export function DialogueView({ board: { talk, phase } }: { board: Board }) {
    const id = useId();
    const history = useCommandHistory();
    const { lines } = talk.dialogue;
    return (
        <section class="console" aria-label="Dialogue">
            <SaidLog label="What was said" said={lines}>
                {lines.map((line, index) => <LineView key={index} line={line} />)}
            </SaidLog>
            <label for={id}>Command (help lists them; ↑ ↓ recall)</label>
            <input
                id={id} type="text" autocomplete="off" spellcheck={false} disabled={phase !== "following"} value={history.text}
                onInput={(event) => history.set(event.currentTarget.value)}
                onKeyDown={(event) => onKey(event, history, (line) => void talk.execute(line))}
            />
        </section>
    );
}
