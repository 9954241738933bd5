// SPDX-License-Identifier: MIT
// Keys with their values, and a field for a new one of each.
import { useState } from "preact/hooks";
import type { LiveKey, Said } from "../core/protocol.ts";
import type { Drafts } from "./drafts.ts";
import type { Keys } from "./use_keys.ts";

interface RowProps {
    given: LiveKey;
    keys: Keys;
    drafts: Drafts;
    isOpen: boolean;
    open(): void;
    set(key: string): void;
}

function About({ meaning, answer }: { meaning: string | undefined; answer: Said | undefined }) {
    return (
        <tr class="about">
            <td colSpan={4}>
                {meaning !== undefined && <p class="note">{meaning}</p>}
                {answer !== undefined && <p class={answer.refused ? "problem" : "note"} role="status">{answer.text}</p>}
            </td>
        </tr>
    );
}

function Row({ given, keys, drafts, isOpen, open, set }: RowProps) {
    const { name, value } = given;
    const meaning = `${given.meaning}; allowed: ${given.allowed}`;
    const answer = keys.answer?.keys.join() === name ? keys.answer : undefined;
    return (
        <tbody onFocusIn={open}>
            <tr title={meaning}>
                <th scope="row">{name}</th>
                <td>{value}</td>
                <td>
                    <input
                        type="text" aria-label={`New value of ${name}`} autocomplete="off" spellcheck={false} value={drafts.of(name)}
                        onInput={(event) => drafts.type(name, event.currentTarget.value)}
                        onKeyDown={(event) => event.key === "Enter" && set(name)}
                    />
                </td>
                <td><button type="button" class="small" aria-label={`Set ${name}`} onClick={() => set(name)}>Set</button></td>
            </tr>
            {(isOpen || answer !== undefined) && <About meaning={isOpen ? meaning : undefined} answer={answer} />}
        </tbody>
    );
}

interface TableProps extends Pick<RowProps, "keys" | "drafts" | "set"> {
    found: LiveKey[];
}

export function KeysTable({ found, ...props }: TableProps) {
    const [opened, setOpened] = useState("");
    return (
        <table class="keys">
            <thead>
                <tr>{["Key", "Value", "New value", "Set"].map((title) => <th key={title} scope="col">{title}</th>)}</tr>
            </thead>
            {found.map((key) => (
                <Row {...props} key={key.name} given={key} isOpen={key.name === opened} open={() => setOpened(key.name)} />
            ))}
        </table>
    );
}
