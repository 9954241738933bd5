// SPDX-License-Identifier: MIT
// Curves that roll: the newest instant is at the right edge. The owner says when to draw, as often as the screen does.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import type { Band } from "./bands.ts";
import { keptInBox, type PlotBoxes } from "./plot_box.ts";
import { axesOf, commonOptions, type Curve, dataOf, seriesOf } from "./plot_panel.tsx";
import { gapsOfTimes } from "./time_gaps.ts";

export interface ScopePicture {
    data: [Float64Array, ...Float32Array[]];
    now: number;
    bands: Band[];
}

interface Props {
    title: string;
    curves: Pick<Curve, "name" | "unit">[];
    span: number; // s
    // Takes the function that draws; gives the one that ends this.
    attach(draw: (picture: ScopePicture) => void): () => void;
}

// A dashed or a thick line of many points takes longer to draw than a frame lasts.
const FAST: Pick<uPlot.Series, "dash" | "width"> = { dash: [], width: 1 };

function made(props: Props, boxes: PlotBoxes, bands: () => Band[]): uPlot {
    const common = commonOptions(boxes, bands);
    const options: uPlot.Options = {
        ...common,
        series: [{ label: "t [s]" }, ...props.curves.map((curve, index) => ({ ...seriesOf(curve, index), ...FAST, gaps: gapsOfTimes }))],
        axes: axesOf(props.curves),
        cursor: { show: false },
        legend: { ...common.legend, live: false },
    };
    const nothing: uPlot.AlignedData = [new Float64Array(), ...props.curves.map(() => new Float32Array())];
    return new uPlot(options, nothing, boxes.plot.current as HTMLDivElement);
}

export function RollingScope(props: Props) {
    const boxes = { plot: useRef<HTMLDivElement>(null), legend: useRef<HTMLDivElement>(null) };
    useEffect(() => {
        let bands: Band[] = [];
        const plot = made(props, boxes, () => bands);
        const detach = props.attach((picture) => {
            bands = picture.bands;
            plot.batch(() => {
                const [times, ...columns] = picture.data;
                plot.setData(dataOf(times, columns), false);
                plot.setScale("x", { min: picture.now - props.span, max: picture.now });
            });
        });
        const end = keptInBox(plot, boxes);
        return () => {
            detach();
            end();
        };
    }, [props.curves, props.span, props.attach]);
    const names = props.curves.map(({ name, unit }) => `${name} [${unit === "" ? "1" : unit}]`).join(", ");
    return (
        <>
            <div ref={boxes.legend} class="plot-legend" />
            <div
                ref={boxes.plot} class="plot" role="img"
                aria-label={`${props.title}: ${names === "" ? "no signal" : names}, the last ${props.span} s`}
            />
        </>
    );
}
