// SPDX-License-Identifier: MIT
// The configuration of the board: its keys to look up and to set while it runs, and all of it as a file.
import { useId, useState } from "preact/hooks";
import type { LiveKey } from "../core/protocol.ts";
import type { Board } from "./board.ts";
import { ConfigurationFiles } from "./configuration_files.tsx";
import { type Drafts, useDrafts } from "./drafts.ts";
import { KeysTable } from "./keys_table.tsx";
import { type Keys, useKeys } from "./use_keys.ts";

const TITLES: Record<string, [string, string]> = {
    unlock: ["Unlock", "At rest: the next configuration may protect less than the one in force. After that it is locked again."],
    store: ["Store", "The next start of the board has what is in force now."],
    defaults: ["Defaults", "What is built into the image comes into force."],
    adopt: ["Adopt files", "Use the values of the chosen files."],
};

// Each word has to be in the name or in the meaning.
function matches({ name, meaning }: LiveKey, search: string): boolean {
    const text = `${name} ${meaning}`.toLowerCase();
    return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

// Several new values, whichever of them the search shows.
function Together({ drafts, keys, set }: { drafts: Drafts; keys: Keys; set(names: string[]): void }) {
    const { answer } = keys;
    const count = drafts.keys.length;
    return (
        <>
            {count > 1 && (
                <div class="buttons" role="group" aria-label="New values">
                    <button type="button" class="main" title={drafts.keys.join(", ")} onClick={() => set(drafts.keys)}>
                        {`Set ${count} keys together`}
                    </button>
                    <button type="button" onClick={() => drafts.forget(drafts.keys)}>Forget them</button>
                </div>
            )}
            {answer !== undefined && answer.keys.length > 1 && (
                <p class={answer.refused ? "problem" : "note"} role="status">{answer.text}</p>
            )}
        </>
    );
}

// Of a board that has gone there are none.
export function Parameters({ board }: { board: Board }) {
    const id = useId();
    const [search, setSearch] = useState("");
    const keys = useKeys(board);
    const drafts = useDrafts();
    const isDisabled = board.phase !== "following";
    const found = keys.all.filter((key) => matches(key, search));
    const set = async (names: string[]): Promise<void> => {
        const values = names.map((name): [string, string] => [name, drafts.of(name).trim()]).filter(([, value]) => value !== "");
        if (values.length > 0 && !(await keys.set(values)).refused) {
            drafts.forget(names);
        }
    };
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
            <ConfigurationFiles board={board} />
            {keys.problem !== "" && <p class="problem" role="alert">{keys.problem}</p>}
            <label for={id}>Search keys by name or meaning</label>
            <input
                id={id} type="search" disabled={isDisabled} value={search} onInput={(event) => setSearch(event.currentTarget.value)}
            />
            <p class="note" role="status">{keys.isAsking ? "Reading…" : `${found.length} of ${keys.all.length} keys`}</p>
            <Together drafts={drafts} keys={keys} set={(names) => void set(names)} />
            <div class="scroll" tabIndex={0} role="group" aria-label="Keys found">
                <KeysTable keys={keys} drafts={drafts} found={found} set={(name) => void set([name])} />
            </div>
        </aside>
    );
}
