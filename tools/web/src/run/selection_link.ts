// SPDX-License-Identifier: MIT
// The choice of the bench in the address of the page. All tabs have the same.
import { choiceOfAddress, keepChoice } from "../address.ts";
import type { Client } from "../core/client.ts";
import type { Choice } from "../core/protocol.ts";
import { packed, unpacked } from "../parts/link.ts";
import { choiceOf, FIRST, plainChoice, type Selection, selectionFrom } from "./bench_state.ts";

// What was kept last: the address has it a moment later.
let newest: Selection | undefined;

interface Linked {
    selection: Selection;
    problem: string; // why it is not the one of the link
}

export async function selectionOfLink(): Promise<Linked> {
    if (newest !== undefined) {
        return { selection: newest, problem: "" };
    }
    const written = choiceOfAddress();
    try {
        return { selection: written === "" ? FIRST : selectionFrom(await unpacked(written)), problem: "" };
    } catch {
        return { selection: FIRST, problem: "The link is damaged; this is the first scenario in its place." };
    }
}

export function keepInLink(selection: Selection): void {
    newest = selection;
    void packed(selection).then((text) => {
        if (newest === selection) {
            keepChoice(text);
        }
    });
}

// Its edited files are written; what the simulator is told comes back.
export async function preparedChoice(client: Client, selection: Selection): Promise<Choice> {
    await client.ask("writeFiles", { files: selection.edits });
    return choiceOf(selection, await client.ask("parts", plainChoice(selection)));
}
