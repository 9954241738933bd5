// SPDX-License-Identifier: MIT
// The stepper's command line: history with the arrow keys, completion with Ctrl+Space, and what was said.
import { useId, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import { useCommandHistory } from "../parts/command_history.ts";
import { SaidLog } from "../parts/said_log.tsx";
import type { Stepper } from "./use_step.ts";

// The longest beginning that all have.
function commonStart(words: string[]): string {
    return words.reduce((start, word) => {
        let length = 0;
        while (length < start.length && start[length] === word[length]) {
            length++;
        }
        return start.slice(0, length);
    });
}

// As in a terminal: an empty line repeats a step.
function repeated(last: string): string {
    return /^(step|back)\b/.test(last) ? last : "";
}

interface Line {
    text: string;
    near: string[]; // what the last word may become
    set(text: string): void;
    enter(): void;
    recall(by: number): void;
    complete(): Promise<void>;
}

function useLine(client: Client, execute: (line: string) => Promise<void>): Line {
    const history = useCommandHistory();
    const [near, setNear] = useState<string[]>([]);
    const { text } = history;
    const set = (next: string): void => {
        history.set(next);
        setNear([]);
    };
    const enter = (): void => {
        const line = text.trim() === "" ? repeated(history.last()) : text.trim();
        if (line !== "") {
            history.keep(line);
            setNear([]);
            void execute(line);
        }
    };
    const recall = (by: number): void => {
        history.recall(by);
        setNear([]);
    };
    const complete = async (): Promise<void> => {
        const word = /\S*$/.exec(text)?.[0] ?? "";
        const before = text.slice(0, text.length - word.length);
        const words = await client.ask("stepComplete", { before, word });
        if (words.length > 0) {
            history.set(before + commonStart(words) + (words.length === 1 ? " " : ""));
        }
        setNear(words.length > 1 ? words : []);
    };
    return { text, near, set, enter, recall, complete };
}

function onKey(event: KeyboardEvent, line: Line): void {
    const acts: Record<string, () => unknown> = {
        Enter: line.enter,
        ArrowUp: () => line.recall(-1),
        ArrowDown: () => line.recall(1),
        ...(event.ctrlKey && { " ": line.complete }),
    };
    const act = acts[event.key];
    if (act !== undefined) {
        event.preventDefault();
        void act();
    }
}

const NEAR_SHOWN = 12;

export function Console({ client, stepper }: { client: Client; stepper: Stepper }) {
    const id = useId();
    const line = useLine(client, stepper.execute);
    return (
        <section class="console" aria-label="Dialogue">
            <SaidLog label="What the stepper said" said={stepper.said}>
                {stepper.said.map(({ line: asked, text, refused }, index) => (
                    <div key={index}>
                        <code>{`> ${asked}`}</code>
                        <pre class={refused ? "problem" : ""}>{text.trimEnd()}</pre>
                    </div>
                ))}
            </SaidLog>
            <label for={id}>Command (help lists them; ↑ ↓ recall, Ctrl+Space completes)</label>
            <input
                id={id} type="text" autocomplete="off" spellcheck={false} value={line.text}
                onInput={(event) => line.set(event.currentTarget.value)} onKeyDown={(event) => onKey(event, line)}
            />
            {line.near.length > 0 && (
                <p class="note" role="status">
                    {line.near.slice(0, NEAR_SHOWN).join("  ")}
                    {line.near.length > NEAR_SHOWN && ` and ${line.near.length - NEAR_SHOWN} more`}
                </p>
            )}
        </section>
    );
}
