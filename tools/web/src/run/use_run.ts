// SPDX-License-Identifier: MIT
// Runs of the chosen files: one at a time, the newest wins.
import { useRef, useState } from "preact/hooks";
import { type Client, type Pending, Stopped } from "../core/client.ts";
import type { Parts, Run } from "../core/protocol.ts";
import { choiceOf, plainChoice, type Selection } from "./bench_state.ts";

export interface Runner {
    run: Run | undefined; // the last one that came to its end
    ran: Selection | undefined; // what it was of
    before: Run | undefined; // the last one of this scenario with other files or imperfections, to compare
    parts: Parts | undefined; // of the last selection that could be read
    progress: number | undefined; // while it runs
    problem: string;
    tookMs: number;
    start(selection: Selection): Promise<void>;
    stop(): void;
}

// What a run is of, without what is drawn of it.
export function filesOf({ scenario, with: sets, edits }: Selection): string {
    return JSON.stringify([scenario, sets, edits]);
}

interface Done {
    run: Run;
    ran: Selection;
    tookMs: number;
}

// A run with other signals is the same run: what came before it stays.
function beforeOf(next: Done, last: (Done & { before: Run | undefined }) | undefined): Run | undefined {
    if (last === undefined || last.ran.scenario !== next.ran.scenario) {
        return undefined;
    }
    return filesOf(last.ran) === filesOf(next.ran) ? last.before : last.run;
}

// Files first, then what they make of the choice.
async function prepared(client: Client, selection: Selection): Promise<Parts> {
    await client.ask("writeFiles", { files: selection.edits });
    return client.ask("parts", plainChoice(selection));
}

export function useRun(client: Client): Runner {
    const [run, setRun] = useState<Done & { before: Run | undefined }>();
    const [parts, setParts] = useState<Parts>();
    const [progress, setProgress] = useState<number>();
    const [problem, setProblem] = useState("");
    const pending = useRef<Pending<Run> | undefined>(undefined);
    const newest = useRef(0);

    async function start(selection: Selection): Promise<void> {
        const own = ++newest.current;
        pending.current?.stop();
        const began = performance.now();
        setProblem("");
        setProgress(0);
        try {
            const found = await prepared(client, selection);
            if (own !== newest.current) {
                return;
            }
            setParts(found);
            const signals = [...new Set(selection.panels.flat())];
            pending.current = client.begin("run", { choice: choiceOf(selection, found), signals }, setProgress);
            const done = await pending.current.done;
            const next = { run: done, ran: selection, tookMs: performance.now() - began };
            setRun((last) => ({ ...next, before: beforeOf(next, last) }));
        } catch (error) {
            if (own === newest.current) {
                setProblem(error instanceof Stopped ? "The run was stopped." : (error as Error).message);
            }
        }
        if (own === newest.current) {
            setProgress(undefined);
        }
    }

    return {
        run: run?.run, ran: run?.ran, before: run?.before, tookMs: run?.tookMs ?? 0, parts, progress, problem, start,
        stop: () => pending.current?.stop(),
    };
}
