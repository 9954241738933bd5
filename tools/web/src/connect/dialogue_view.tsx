// SPDX-License-Identifier: MIT
// A command line to the board, and what was said.
import { useId } from "preact/hooks";
import { type CommandHistory, useCommandHistory } from "../parts/command_history.ts";
import { SaidLog } from "../parts/said_log.tsx";
import type { Board } from "./board.ts";
import type { Said } from "./dialogue.ts";

function Line({ said: { kind, text } }: { said: Said }) {
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
    const { said } = talk.dialogue;
    return (
        <section class="console" aria-label="Dialogue">
            <SaidLog label="What was said" said={said}>
                {said.map((one, index) => <Line key={index} said={one} />)}
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
