// SPDX-License-Identifier: MIT
// The choice of the bench in the address of the page. All tabs have the same.
import type { Client } from "../core/client.ts";
import type { Choice } from "../core/protocol.ts";
import { packed, unpacked } from "../parts/link.ts";
import { choiceOf, FIRST, plainChoice, type Selection, selectionFrom } from "./bench_state.ts";

const LINK = /^#run=(.+)$/;

// What was kept last: the address has it a moment later.
let newest: Selection | undefined;

export async function selectionOfLink(): Promise<Selection> {
    if (newest !== undefined) {
        return newest;
    }
    const written = LINK.exec(location.hash)?.[1];
    return written === undefined ? FIRST : selectionFrom(await unpacked(written));
}

export function keepInLink(selection: Selection): void {
    newest = selection;
    void packed(selection).then((text) => {
        if (newest === selection) {
            history.replaceState(null, "", `#run=${text}`);
        }
    });
}

// Its edited files are written; what the simulator is told comes back.
export async function preparedChoice(client: Client, selection: Selection): Promise<Choice> {
    await client.ask("writeFiles", { files: selection.edits });
    return choiceOf(selection, await client.ask("parts", plainChoice(selection)));
}
