// SPDX-License-Identifier: MIT
// What a run leaves for other programs: the trace as the program writes it, and a picture of the panels.
import type { Client } from "../core/client.ts";
import { download } from "../parts/format.ts";
import { argumentsOf, choiceOf, type Parts, type Selection } from "./bench_state.ts";

const TRACE = "/tmp/trace.csv";

// Ending a run with a limit that does not hold is no failure here.
const WRONG_INPUT = 2;

export async function downloadTrace(client: Client, selection: Selection, parts: Parts): Promise<void> {
    await client.ask("writeFiles", { files: selection.edits });
    const args = [...argumentsOf(choiceOf(selection, parts)), "--trace", TRACE];
    const { files, status, stderr } = await client.ask("program", { args, files: [TRACE] });
    if (status === WRONG_INPUT) {
        throw new Error(stderr);
    }
    download(`${selection.scenario}.csv`, new Blob([files[TRACE] ?? ""], { type: "text/csv" }));
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
