// SPDX-License-Identifier: MIT
// The page: its head, its tabs, and the one that is open.
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { addEntry, nameEntry, onEntry, type View, viewOfAddress } from "./address.ts";
import { BoardLine } from "./connect/board_line.tsx";
import { Client } from "./core/client.ts";
import { isolateLater } from "./parts/isolation.ts";
import { setTheme, type Theme, THEMES } from "./parts/theme.ts";
import type { Tab, TabProps } from "./tab.ts";
import { TABS } from "./tabs.ts";

function ThemeChoice() {
    return (
        <label class="theme">
            Colours
            <select onChange={(event) => setTheme(event.currentTarget.value as Theme)}>
                {THEMES.map((name) => <option key={name}>{name}</option>)}
            </select>
        </label>
    );
}

// The arrow keys go from tab to tab.
function onArrow(event: KeyboardEvent, open: Tab, show: (tab: Tab) => void): void {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step !== undefined) {
        const next = TABS[(TABS.indexOf(open) + step + TABS.length) % TABS.length] as Tab;
        show(next);
        document.getElementById(`tab-${next.id}`)?.focus();
    }
}

function TabList({ open, show }: { open: Tab; show(tab: Tab): void }) {
    return (
        <div role="tablist" aria-label="Parts of the bench" onKeyDown={(event) => onArrow(event, open, show)}>
            {TABS.map((tab) => (
                <button
                    type="button" role="tab" key={tab.id} id={`tab-${tab.id}`} aria-controls="tab-panel"
                    aria-selected={tab === open} tabIndex={tab === open ? 0 : -1} onClick={() => show(tab)}
                >
                    {tab.title}
                </button>
            ))}
        </div>
    );
}

// The open view is the one of the address.
function useView(): [Tab, View, (next: View) => void] {
    const [view, setView] = useState({ ...viewOfAddress(), what: "" }); // what it was for is gone with the page that was there before
    const tab = TABS.find(({ id }) => id === view.id) ?? (TABS[0] as Tab);
    useEffect(() => {
        const gone = new AbortController();
        onEntry(setView, gone.signal);
        return () => gone.abort();
    }, []);
    // Also an entry that was made with another choice: the page has the newest one.
    useEffect(() => {
        nameEntry({ id: tab.id, what: view.what });
        document.title = `${tab.title} – neurofoc bench`;
    }, [view]);
    const show = (next: View): void => {
        if (next.id !== tab.id) {
            addEntry(next);
            setView(next);
        }
    };
    return [tab, view, show];
}

function Page({ client }: { client: Client }) {
    const [loaded, setLoaded] = useState<Omit<TabProps, "show" | "what">>();
    const [problem, setProblem] = useState("");
    const [open, { what }, showView] = useView();
    const show = (id: string, given = ""): void => showView({ id, what: given });
    useEffect(() => {
        client.ask("load", null).then(
            (answer) => setLoaded({ client, ...answer }),
            (error: Error) => setProblem(error.message),
        );
    }, []);
    return (
        <>
            <header class="head">
                <h1>neurofoc bench</h1>
                <TabList open={open} show={({ id }) => show(id)} />
                <BoardLine isShown={open.id !== "connect"} />
                <ThemeChoice />
            </header>
            <main>
                <div id="tab-panel" role="tabpanel" aria-labelledby={`tab-${open.id}`}>
                    {problem !== "" && <p class="problem" role="alert">{problem}</p>}
                    {loaded === undefined ? <p role="status">Loading the simulator…</p> : <open.view {...loaded} show={show} what={what} />}
                </div>
            </main>
        </>
    );
}

isolateLater();
render(<Page client={new Client()} />, document.getElementById("page") as HTMLElement);
