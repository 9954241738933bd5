// SPDX-License-Identifier: MIT
// The address of the page: the view that is open, and the choice of the bench, packed: #play=CHOICE. Each view that was open is an
// entry of the browser's history, so that Back and Forward go from view to view and what was played stays.

export interface View {
    id: string; // of a row of TABS
    what: string; // for it
}

const FORM = /^#([a-z]+)(?:=(.+))?$/;
const OLD_NAMES: Record<string, string> = { run: "simulate" }; // of links that were sent

let choice = choiceOfAddress();

export function choiceOfAddress(): string {
    return FORM.exec(location.hash)?.[2] ?? "";
}

function idOfAddress(): string {
    const id = FORM.exec(location.hash)?.[1] ?? "";
    return OLD_NAMES[id] ?? id;
}

function addressOf(id: string): string {
    return choice === "" ? `#${id}` : `#${id}=${choice}`;
}

// An entry that the page has made has a View as its state; an address that a person has typed has none.
export function viewOfAddress(): View {
    const state = history.state as View | null;
    return { id: idOfAddress(), what: state?.what ?? "" };
}

// The present entry shows it from now on.
export function nameEntry({ id, what }: View): void {
    history.replaceState({ id, what }, "", addressOf(id));
}

export function addEntry({ id, what }: View): void {
    history.pushState({ id, what }, "", addressOf(id));
}

export function keepChoice(packed: string): void {
    choice = packed;
    nameEntry(viewOfAddress());
}

// Calls `show` when a person has gone to another entry. A link to another choice, typed over this one, is opened as in a new page.
export function onEntry(show: (view: View) => void, signal: AbortSignal): void {
    const go = (): void => {
        const isTyped = history.state === null;
        if (isTyped && choiceOfAddress() !== "" && choiceOfAddress() !== choice) {
            location.reload();
        } else {
            show(viewOfAddress());
        }
    };
    addEventListener("popstate", go, { signal });
}
