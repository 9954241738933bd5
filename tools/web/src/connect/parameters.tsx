// SPDX-License-Identifier: MIT
// The keys of motor, board and tuning in a table, to look up and to set while the board runs.
import { useId, useState } from "preact/hooks";
import type { LiveKey, Said } from "../core/protocol.ts";
import type { Board } from "./board.ts";
import { type Keys, useKeys } from "./use_keys.ts";

const TITLES: Record<string, [string, string]> = {
    store: ["Store", "The next start of the board has what is in force now."],
    defaults: ["Defaults", "What is built into the image comes into force."],
    adopt: ["Adopt files", "Use the values of the chosen files."],
};

// Each word has to be in the name or in the meaning.
function matches({ name, meaning }: LiveKey, search: string): boolean {
    const text = `${name} ${meaning}`.toLowerCase();
    return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

interface RowProps {
    given: LiveKey;
    keys: Keys;
    isOpen: boolean;
    open(): void;
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

function Row({ given, keys, isOpen, open }: RowProps) {
    const { name, value } = given;
    const meaning = `${given.meaning}; allowed: ${given.allowed}`;
    const [text, setText] = useState("");
    const set = async (): Promise<void> => {
        if (text.trim() !== "" && !(await keys.set(name, text.trim())).refused) {
            setText("");
        }
    };
    const answer = keys.answer?.key === name ? keys.answer : undefined;
    return (
        <tbody onFocusIn={open}>
            <tr title={meaning}>
                <th scope="row">{name}</th>
                <td>{value}</td>
                <td>
                    <input
                        type="text" aria-label={`New value of ${name}`} autocomplete="off" spellcheck={false} value={text}
                        onInput={(event) => setText(event.currentTarget.value)}
                        onKeyDown={(event) => event.key === "Enter" && void set()}
                    />
                </td>
                <td><button type="button" class="small" aria-label={`Set ${name}`} onClick={() => void set()}>Set</button></td>
            </tr>
            {(isOpen || answer !== undefined) && <About meaning={isOpen ? meaning : undefined} answer={answer} />}
        </tbody>
    );
}

function Table({ keys, found }: { keys: Keys; found: LiveKey[] }) {
    const [opened, setOpened] = useState("");
    return (
        <table class="keys">
            <thead>
                <tr>{["Key", "Value", "New value", "Set"].map((title) => <th key={title} scope="col">{title}</th>)}</tr>
            </thead>
            {found.map((key) => (
                <Row key={key.name} given={key} keys={keys} isOpen={key.name === opened} open={() => setOpened(key.name)} />
            ))}
        </table>
    );
}

// Of a board that has gone there are none.
export function Parameters({ board }: { board: Board }) {
    const id = useId();
    const [search, setSearch] = useState("");
    const keys = useKeys(board);
    const isDisabled = board.phase !== "following";
    const found = keys.all.filter((key) => matches(key, search));
    return (
        <aside class="parameters" aria-label="Parameters">
            <div class="buttons" role="group" aria-label="All parameters">
                {Object.entries(TITLES).map(([line, [text, title]]) => (
                    <button
                        type="button" key={line} title={title} disabled={isDisabled} onClick={() => void board.talk.execute(line)}
                    >
                        {text}
                    </button>
                ))}
                <button type="button" disabled={isDisabled} onClick={keys.ask}>Read again</button>
            </div>
            {keys.problem !== "" && <p class="problem" role="alert">{keys.problem}</p>}
            <label for={id}>Search keys by name or meaning</label>
            <input
                id={id} type="search" disabled={isDisabled} value={search} onInput={(event) => setSearch(event.currentTarget.value)}
            />
            <p class="note" role="status">{keys.isAsking ? "Reading…" : `${found.length} of ${keys.all.length} keys`}</p>
            <div class="scroll" tabIndex={0} role="group" aria-label="Keys found"><Table keys={keys} found={found} /></div>
        </aside>
    );
}
