// SPDX-License-Identifier: MIT
// What a run leaves for other programs: the trace and the results as the program writes them, and a picture of the panels.
import { useState } from "preact/hooks";
import { type Client, type Pending, Stopped } from "../core/client.ts";
import type { Parts, Run } from "../core/protocol.ts";
import { download } from "../parts/format.ts";
import { choiceOf, type Selection } from "./bench_state.ts";

interface TraceProps {
    client: Client;
    selection: Selection;
    parts: Parts | undefined;
    onProblem(text: string): void;
}

// The same run once more, into a file: it takes longer, and can be stopped.
export function TraceButton({ client, selection, parts, onProblem }: TraceProps) {
    const [pending, setPending] = useState<Pending<string>>();
    const [share, setShare] = useState(0);
    if (pending !== undefined) {
        return <button type="button" onClick={pending.stop}>{`Stop the trace (${Math.floor(share * 100)} %)`}</button>;
    }
    const begin = (known: Parts): void => {
        onProblem("");
        setShare(0);
        void client.ask("writeFiles", { files: selection.edits });
        const trace = client.begin("trace", { choice: choiceOf(selection, known) }, setShare);
        setPending(trace);
        trace.done
            .then((text) => download(`${selection.scenario}.csv`, new Blob([text], { type: "text/csv" })))
            .catch((error: Error) => onProblem(error instanceof Stopped ? "The trace was stopped." : error.message))
            .finally(() => setPending(undefined));
    };
    return (
        <button type="button" disabled={parts === undefined} onClick={() => parts !== undefined && begin(parts)}>
            Download trace (CSV)
        </button>
    );
}

export function downloadResults(name: string, { json }: Run): void {
    download(`${name}.json`, new Blob([json], { type: "application/json" }));
}

// Below each other, as they are on the screen.
export function downloadPicture(name: string): void {
    const plots = [...document.querySelectorAll<HTMLCanvasElement>(".panel canvas")];
    const picture = document.createElement("canvas");
    picture.width = Math.max(...plots.map(({ width }) => width));
    picture.height = plots.reduce((sum, { height }) => sum + height, 0);
    const context = picture.getContext("2d") as CanvasRenderingContext2D;
    context.fillStyle = getComputedStyle(document.body).backgroundColor;
    context.fillRect(0, 0, picture.width, picture.height);
    let top = 0;
    for (const plot of plots) {
        context.drawImage(plot, 0, top);
        top += plot.height;
    }
    picture.toBlob((blob) => blob !== null && download(`${name}.png`, blob));
}
