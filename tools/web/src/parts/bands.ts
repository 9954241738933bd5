// SPDX-License-Identifier: MIT
// States and faults behind the curves.
import type uPlot from "uplot";
import { token } from "./theme.ts";

export interface Band {
    from: number;
    to: number; // the same as `from`: an instant
    label: string;
    kind: "state" | "fault";
}

const LABEL_PX = 12;
const GAP_PX = 4;

// Room above a plot for the names of the states: in the plot, its grid and its curves would cross them.
export const LABELS_PX = LABEL_PX + 2 * GAP_PX;

interface Painted {
    band: Band;
    index: number; // among the bands
    left: number;
    right: number;
}

function paintGround({ ctx, bbox }: uPlot, { band, index, left, right }: Painted): void {
    ctx.fillStyle = band.kind === "fault" ? token("--bad") : token(`--band-${(index % 2) + 1}`);
    ctx.fillRect(left, bbox.top, band.kind === "fault" ? 2 * devicePixelRatio : right - left, bbox.height);
}

// A state's name only where its ground has room for it.
function paintLabel({ ctx, bbox }: uPlot, { band, left, right }: Painted): void {
    const gap = GAP_PX * devicePixelRatio;
    const { width } = ctx.measureText(band.label);
    if (band.kind === "fault") {
        const hasRoom = left + gap + width < bbox.left + bbox.width;
        ctx.fillStyle = token("--bad");
        ctx.fillText(band.label, hasRoom ? left + gap : left - gap - width, bbox.top + bbox.height - gap);
        return;
    }
    const from = Math.max(left, bbox.left);
    if (width + gap < Math.min(right, bbox.left + bbox.width) - from) {
        ctx.fillStyle = token("--text-soft");
        ctx.fillText(band.label, from, bbox.top - gap);
    }
}

type Paint = (plot: uPlot, painted: Painted) => void;

function painter(bands: () => Band[], paint: Paint): (plot: uPlot) => void {
    return (plot) => {
        const { ctx, bbox } = plot;
        ctx.save();
        ctx.beginPath();
        ctx.rect(bbox.left, 0, bbox.width, bbox.top + bbox.height);
        ctx.clip();
        ctx.font = `${LABEL_PX * devicePixelRatio}px system-ui`;
        ctx.textBaseline = "alphabetic";
        ctx.textAlign = "left";
        bands().forEach((band, index) => paint(plot, {
            band, index, left: plot.valToPos(band.from, "x", true), right: plot.valToPos(band.to, "x", true),
        }));
        ctx.restore();
    };
}

// Grounds below the grid, names above it. Every other state has a ground of its own; its name says which it is.
export function bandHooks(bands: () => Band[]): uPlot.Hooks.Arrays {
    return { drawClear: [painter(bands, paintGround)], drawAxes: [painter(bands, paintLabel)] };
}
