// SPDX-License-Identifier: MIT
// States and faults behind the curves.
import type uPlot from "uplot";
import type { Band } from "./plot_panel.tsx";
import { token } from "./theme.ts";

const LABEL_PX = 12;

function paintState(plot: uPlot, band: Band, colour: string, text: string): void {
    const { ctx, bbox } = plot;
    const left = plot.valToPos(band.from, "x", true);
    const right = plot.valToPos(band.to, "x", true);
    ctx.fillStyle = colour;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
    if (ctx.measureText(band.label).width + 8 < right - Math.max(left, bbox.left)) {
        ctx.fillStyle = text;
        ctx.fillText(band.label, Math.max(left, bbox.left) + 4, bbox.top + 2);
    }
}

function paintFault(plot: uPlot, band: Band, colour: string): void {
    const { ctx, bbox } = plot;
    const at = plot.valToPos(band.from, "x", true);
    ctx.fillStyle = colour;
    ctx.fillRect(at, bbox.top, 2, bbox.height);
    ctx.fillText(band.label, at + 5, bbox.top + bbox.height - LABEL_PX * devicePixelRatio - 4);
}

// For the hook that draws before the curves. Every other state has a ground of its own; its name says which it is.
export function bandPainter(bands: () => Band[]): (plot: uPlot) => void {
    return (plot) => {
        const { ctx, bbox } = plot;
        ctx.save();
        ctx.beginPath();
        ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
        ctx.clip();
        ctx.font = `${LABEL_PX * devicePixelRatio}px system-ui`;
        ctx.textBaseline = "top";
        ctx.textAlign = "left";
        bands().forEach((band, index) => {
            if (band.kind === "state") {
                paintState(plot, band, token(`--band-${(index % 2) + 1}`), token("--text-soft"));
            } else {
                paintFault(plot, band, token("--bad"));
            }
        });
        ctx.restore();
    };
}
