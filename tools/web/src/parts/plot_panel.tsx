// SPDX-License-Identifier: MIT
// Curves over time: zoom by dragging or the wheel, pan with the shift key, cursor with values, bands behind the curves.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { type Band, bandHooks, LABELS_PX } from "./bands.ts";
import { shown, withUnit } from "./format.ts";
import { keptInBox, legendIn, type PlotBoxes, sizeOf } from "./plot_box.ts";
import { token } from "./theme.ts";

export interface Curve {
    name: string;
    unit: string;
    values: ArrayLike<number | null>; // null: not known
    isBefore?: boolean; // of another run, to compare
}

export interface Range {
    from: number;
    to: number;
}

interface Props {
    title: string;
    times: Float64Array;
    curves: Curve[];
    bands: Band[];
    range: Range; // shown
    whole: Range;
    onRange(range: Range): void;
    syncKey: string; // panels of one key share the cursor
}

const COLOURS = 7; // --curve-1 …
const ZOOM_STEP = 0.8;
const PAN_STEP = 0.1;
const CURSOR_STEP_PX = 8;
const GRID_PX = 1; // not thicker than a curve
const VALUE_SPACE_PX = 24; // between two values of an axis: a plot may be low

// An estimate, a reference or a command is dashed beside what is true.
function dashOf(name: string): number[] | undefined {
    if (name.includes("estimated")) {
        return [8, 4];
    }
    return /reference|command/.test(name) ? [2, 3] : undefined;
}

// Faint, in the colour of its curve, without a line of its own in the legend.
function faint(curves: Curve[], curve: Curve): Partial<uPlot.Series> {
    const index = curves.findIndex(({ name }) => name === curve.name);
    return { class: "before", alpha: 0.35, stroke: () => token(`--curve-${(index % COLOURS) + 1}`) };
}

export function seriesOf(curve: Pick<Curve, "name" | "unit">, index: number): uPlot.Series {
    const dash = dashOf(curve.name);
    return {
        label: withUnit(curve.name, curve.unit === "" ? "" : `[${curve.unit}]`),
        scale: `y ${curve.unit}`,
        stroke: () => token(`--curve-${(index % COLOURS) + 1}`),
        width: 1.5,
        points: { show: false },
        value: (_plot, value) => shown(value, curve.unit),
        ...(dash === undefined ? {} : { dash }),
    };
}

// One axis a unit, the first at the left.
export function axesOf(curves: Pick<Curve, "unit">[]): uPlot.Axis[] {
    const common: uPlot.Axis = {
        stroke: () => token("--text-soft"),
        grid: { stroke: () => token("--line"), width: GRID_PX },
        ticks: { stroke: () => token("--line"), width: GRID_PX, size: 5 },
        font: "12px system-ui",
        labelFont: "12px system-ui",
    };
    const units = [...new Set(curves.map(({ unit }) => unit))];
    const y = units.map((unit, index): uPlot.Axis => ({
        ...common,
        scale: `y ${unit}`,
        side: index === 0 ? 3 : 1,
        label: unit === "" ? "1" : unit,
        labelSize: 18,
        size: 58,
        space: VALUE_SPACE_PX,
        grid: { ...common.grid, show: index === 0 },
    }));
    return [{ ...common, label: "t [s]", labelSize: 14, size: 26 }, ...y];
}

// Of each plot over time.
export function commonOptions(boxes: PlotBoxes, bands: () => Band[]): Omit<uPlot.Options, "series"> {
    return {
        ...sizeOf(boxes),
        padding: [LABELS_PX, null, null, null],
        scales: { x: { time: false, range: (_plot, min, max) => [min, max] } },
        legend: legendIn(boxes),
        hooks: bandHooks(bands),
    };
}

function optionsOf(props: Props, boxes: PlotBoxes, onRange: (range: Range) => void): uPlot.Options {
    const common = commonOptions(boxes, () => props.bands);
    return {
        ...common,
        series: [{ label: "t [s]", value: (_plot, value) => shown(value) }, ...props.curves.map((curve, index) => ({
            ...seriesOf(curve, index), ...(curve.isBefore && faint(props.curves, curve)),
        }))],
        axes: axesOf(props.curves),
        cursor: { sync: { key: props.syncKey }, drag: { x: true, y: false }, points: { size: 6 } },
        hooks: {
            ...common.hooks,
            setSelect: [
                (plot) => {
                    if (plot.select.width > 0) {
                        const at = (px: number): number => plot.posToVal(px, "x");
                        onRange({ from: at(plot.select.left), to: at(plot.select.left + plot.select.width) });
                    }
                },
            ],
        },
    };
}

// A plot leaves out what is null. A NaN at the beginning would become an end of its scale, and nothing of the plot would be drawn.
function known(values: Curve["values"]): Curve["values"] {
    const all = Array.from(values);
    return all.some(Number.isNaN) ? all.map((value) => (Number.isNaN(value) ? null : value)) : values;
}

// uPlot takes arrays of either kind.
export function dataOf(times: Float64Array, columns: Curve["values"][]): uPlot.AlignedData {
    return [times, ...columns.map(known)] as uPlot.AlignedData;
}

function zoomed({ from, to }: Range, factor: number, centre: number): Range {
    return { from: centre - (centre - from) * factor, to: centre + (to - centre) * factor };
}

// Within the whole, of the same width where it fits.
function kept(range: Range, whole: Range): Range {
    const width = Math.min(range.to - range.from, whole.to - whole.from);
    const from = Math.min(Math.max(range.from, whole.from), whole.to - width);
    return { from, to: from + width };
}

// The range that a key asks for; none for another key.
function rangeOfKey(key: string, shift: boolean, range: Range, whole: Range): Range | undefined {
    const centre = (range.from + range.to) / 2;
    const step = (range.to - range.from) * PAN_STEP;
    const ranges: Record<string, Range> = {
        "+": zoomed(range, ZOOM_STEP, centre),
        "-": zoomed(range, 1 / ZOOM_STEP, centre),
        "0": whole,
        ...(shift && {
            ArrowLeft: { from: range.from - step, to: range.to - step },
            ArrowRight: { from: range.from + step, to: range.to + step },
        }),
    };
    return ranges[key];
}

function moveCursor(plot: uPlot, step: number): void {
    const left = plot.cursor.left ?? -1;
    const from = left < 0 ? plot.bbox.width / devicePixelRatio / 2 : left;
    plot.setCursor({ left: Math.max(0, from + step), top: 10 });
}

function onKey(event: KeyboardEvent, plot: uPlot, props: Props): void {
    const range = rangeOfKey(event.key, event.shiftKey, props.range, props.whole);
    if (range !== undefined) {
        props.onRange(kept(range, props.whole));
    } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
        moveCursor(plot, event.key === "ArrowLeft" ? -CURSOR_STEP_PX : CURSOR_STEP_PX);
    } else {
        return;
    }
    event.preventDefault();
}

// The wheel zooms about the pointer; with the shift key it pans.
function onWheel(event: WheelEvent, plot: uPlot, props: Props): void {
    event.preventDefault();
    const { range, whole } = props;
    const by = event.deltaY === 0 ? event.deltaX : event.deltaY;
    const step = (range.to - range.from) * PAN_STEP * Math.sign(by);
    const at = plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
    const moved = { from: range.from + step, to: range.to + step };
    props.onRange(kept(event.shiftKey ? moved : zoomed(range, by > 0 ? 1 / ZOOM_STEP : ZOOM_STEP, at), whole));
}

function described({ title, curves, range }: Props): string {
    const names = curves.filter(({ isBefore }) => !isBefore).map(({ name, unit }) => withUnit(name, unit)).join(", ");
    const others = curves.some(({ isBefore }) => isBefore) ? ", and of the run before" : "";
    return `${title}: ${names === "" ? "no signal" : names}${others}, ${shown(range.from)} s to ${shown(range.to)} s. `
        + "Arrow keys move the cursor, with shift they pan; plus and minus zoom, 0 shows all.";
}

export function PlotPanel(props: Props) {
    const boxes = { plot: useRef<HTMLDivElement>(null), legend: useRef<HTMLDivElement>(null) };
    const plot = useRef<uPlot | undefined>(undefined);
    const latest = useRef(props); // for listeners that live as long as the plot
    latest.current = props;

    useEffect(() => {
        const options = optionsOf(props, boxes, (range) => latest.current.onRange(range));
        const made = new uPlot(options, dataOf(props.times, props.curves.map(({ values }) => values)), boxes.plot.current as HTMLDivElement);
        plot.current = made;
        made.setScale("x", { min: latest.current.range.from, max: latest.current.range.to });
        made.over.addEventListener("wheel", (event) => onWheel(event, made, latest.current), { passive: false });
        made.over.addEventListener("dblclick", () => latest.current.onRange(latest.current.whole));
        return keptInBox(made, boxes);
    }, [props.times, props.curves, props.bands]);

    useEffect(() => {
        plot.current?.setScale("x", { min: props.range.from, max: props.range.to });
    }, [props.range]);

    return (
        <>
            <div ref={boxes.legend} class="plot-legend" />
            <div
                ref={boxes.plot}
                class="plot"
                role="group"
                tabIndex={0}
                aria-label={described(props)}
                onKeyDown={(event) => plot.current && onKey(event, plot.current, props)}
            />
        </>
    );
}
