// SPDX-License-Identifier: MIT
// Simulate: a scenario that is run with its imperfections and edited files, its figures beside their limits, and the curves.
import { useEffect, useState } from "preact/hooks";
import type { TabProps } from "../tab.ts";
import { argumentsOf, choiceOf, type Selection } from "./bench_state.ts";
import { Curves } from "./curves.tsx";
import { downloadPicture, downloadResults, TraceButton } from "./downloads.tsx";
import { Files } from "./files.tsx";
import { Results } from "./results.tsx";
import { keepInLink, selectionOfLink } from "./selection_link.ts";
import { Setup } from "./setup.tsx";
import { filesOf, type Runner, useRun } from "./use_run.ts";

function isStale(runner: Runner, selection: Selection): boolean {
    const { ran } = runner;
    return ran !== undefined && filesOf(ran) !== filesOf(selection);
}

interface MainProps {
    props: TabProps;
    runner: Runner;
    selection: Selection;
    select(selection: Selection): void;
}

function Toolbar({ props, runner, selection, view, setView }: MainProps & { view: string; setView(view: string): void }) {
    const [problem, setProblem] = useState("");
    const { run, parts } = runner;
    return (
        <div class="buttons toolbar">
            {["Curves", "Files"].map((name) => (
                <button type="button" key={name} aria-pressed={view === name} onClick={() => setView(name)}>{name}</button>
            ))}
            <span class="gap" />
            <TraceButton client={props.client} selection={selection} parts={parts} onProblem={setProblem} />
            <button
                type="button" disabled={run === undefined}
                onClick={() => run !== undefined && downloadResults(selection.scenario, run)}
            >
                Download results (JSON)
            </button>
            <button type="button" disabled={run === undefined || view !== "Curves"} onClick={() => downloadPicture(selection.scenario)}>
                Download picture
            </button>
            {parts !== undefined && <code>{`motorsim ${argumentsOf(choiceOf(selection, parts)).join(" ")}`}</code>}
            {problem !== "" && <p class="problem" role="alert">{problem}</p>}
        </div>
    );
}

function Main(props: MainProps) {
    const { runner, selection, select } = props;
    const { run, before, parts } = runner;
    const [view, setView] = useState("Curves");
    // Other signals: the same once more, with them.
    const setPanels = (panels: string[][]): void => {
        const next = { ...selection, panels };
        select(next);
        if (panels.flat().some((name) => run?.columns[name] === undefined)) {
            void runner.start(next);
        }
    };
    return (
        <div class="run-main">
            <Toolbar {...props} view={view} setView={setView} />
            {view === "Curves" && run !== undefined && <Curves run={run} before={before} panels={selection.panels} onPanels={setPanels} />}
            {view === "Files" && parts !== undefined && (
                <Files
                    key={selection.scenario} client={props.props.client} schema={props.props.schema}
                    selection={selection} parts={parts} onSelect={select}
                />
            )}
        </div>
    );
}

function Status({ runner, selection }: { runner: Runner; selection: Selection }) {
    const stale = isStale(runner, selection) && runner.progress === undefined;
    const done = `${runner.run?.head.ticks} ticks in ${Math.round(runner.tookMs)} ms.`;
    return (
        <p class="note" role="status">
            {stale ? "The choice has changed since this run: press Simulate." : runner.run === undefined ? "" : done}
        </p>
    );
}

export function RunTab(props: TabProps) {
    const runner = useRun(props.client);
    const [selection, setSelection] = useState<Selection>();
    const [problem, setProblem] = useState("");
    const select = (next: Selection): void => {
        setSelection(next);
        keepInLink(next);
    };
    useEffect(() => {
        const begin = (first: Selection): void => {
            setSelection(first);
            void runner.start(first);
        };
        void selectionOfLink().then((linked) => {
            setProblem(linked.problem);
            begin(linked.selection);
        });
    }, []);
    if (selection === undefined) {
        return null;
    }
    // Another scenario or set runs at once; an edited file waits for the button.
    const choose = (next: Selection): void => {
        select(next);
        void runner.start(next);
    };
    return (
        <div class="run">
            <div class="side">
                {problem !== "" && <p class="problem" role="alert">{problem}</p>}
                <Setup names={props.names} selection={selection} runner={runner} onSelect={choose} />
                <Status runner={runner} selection={selection} />
                {runner.run !== undefined && <Results run={runner.run} before={runner.before} busy={runner.progress !== undefined} />}
            </div>
            <Main props={props} runner={runner} selection={selection} select={select} />
        </div>
    );
}
