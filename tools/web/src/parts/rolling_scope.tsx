// SPDX-License-Identifier: MIT
// Curves that roll: the newest instant is at the right edge. The owner says when to draw, as often as the screen does.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { bandPainter } from "./bands.ts";
import { axesOf, type Band, type Curve, seriesOf } from "./plot_panel.tsx";
import { onThemeChange } from "./theme.ts";
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
    height: number;
    // Takes the function that draws; gives the one that ends this.
    attach(draw: (picture: ScopePicture) => void): () => void;
}

// A dashed or a thick line of many points takes longer to draw than a frame lasts.
const FAST: Pick<uPlot.Series, "dash" | "width"> = { dash: [], width: 1 };

// A scope is low.
const TICK_SPACE_PX = 18;

function made(props: Props, element: HTMLElement, bands: () => Band[]): uPlot {
    const options: uPlot.Options = {
        width: element.clientWidth,
        height: props.height,
        scales: { x: { time: false, range: (_plot, min, max) => [min, max] } },
        series: [{ label: "t [s]" }, ...props.curves.map((curve, index) => ({ ...seriesOf(curve, index), ...FAST, gaps: gapsOfTimes }))],
        axes: axesOf(props.curves).map((axis, index) => (index === 0 ? axis : { ...axis, space: TICK_SPACE_PX })),
        cursor: { show: false },
        legend: { live: false },
        hooks: { drawClear: [bandPainter(bands)] },
    };
    return new uPlot(options, [new Float64Array(), ...props.curves.map(() => new Float32Array())], element);
}

export function RollingScope(props: Props) {
    const box = useRef<HTMLDivElement>(null);
    useEffect(() => {
        const element = box.current as HTMLDivElement;
        let bands: Band[] = [];
        const plot = made(props, element, () => bands);
        const detach = props.attach((picture) => {
            bands = picture.bands;
            plot.batch(() => {
                plot.setData(picture.data, false);
                plot.setScale("x", { min: picture.now - props.span, max: picture.now });
            });
        });
        const sized = new ResizeObserver(() => plot.setSize({ width: element.clientWidth, height: props.height }));
        sized.observe(element);
        const gone = new AbortController();
        onThemeChange(() => plot.redraw(false, true), gone.signal);
        return () => {
            gone.abort();
            sized.disconnect();
            detach();
            plot.destroy();
        };
    }, [props.curves, props.span, props.height, props.attach]);
    const names = props.curves.map(({ name, unit }) => `${name} [${unit === "" ? "1" : unit}]`).join(", ");
    return (
        <div
            ref={box} class="plot" role="img"
            aria-label={`${props.title}: ${names === "" ? "no signal" : names}, the last ${props.span} s`}
        />
    );
}
