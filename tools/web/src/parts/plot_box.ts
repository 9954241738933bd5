// SPDX-License-Identifier: MIT
// A plot fills its box, which the style sheet sizes, and has its legend in another one.
import type { RefObject } from "preact";
import type uPlot from "uplot";
import { onThemeChange } from "./theme.ts";

export interface PlotBoxes {
    plot: RefObject<HTMLDivElement | null>;
    legend: RefObject<HTMLDivElement | null>;
}

export function sizeOf({ plot }: PlotBoxes): { width: number; height: number } {
    const { clientWidth: width = 0, clientHeight: height = 0 } = plot.current ?? {};
    return { width, height };
}

export function legendIn({ legend }: PlotBoxes): uPlot.Legend {
    return { mount: (_plot, table) => legend.current?.replaceChildren(table) };
}

// Gives the function that ends the plot.
export function keptInBox(plot: uPlot, boxes: PlotBoxes): () => void {
    const sized = new ResizeObserver(() => plot.setSize(sizeOf(boxes)));
    sized.observe(plot.root.parentElement as HTMLElement);
    const gone = new AbortController();
    onThemeChange(() => plot.redraw(false, true), gone.signal);
    return () => {
        gone.abort();
        sized.disconnect();
        plot.destroy();
        boxes.legend.current?.replaceChildren();
    };
}
