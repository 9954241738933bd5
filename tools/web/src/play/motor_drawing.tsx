// SPDX-License-Identifier: MIT
// The rotor, where the drive believes it to be, and the current vector, in electrical angles: phase a is at 0°, and angles count
// against the clock. In the estimated frame the estimate stands still, so that an error shows at any speed.
import { useEffect, useRef, useState } from "preact/hooks";
import type { PlayBlock } from "../core/protocol.ts";
import { shown } from "../parts/format.ts";
import type { Player } from "./player.ts";

const RADIUS = 100;
const LONGEST = 88; // of the current vector, at the largest current of the motor

function rotate(element: SVGElement | null, degrees: number): void {
    element?.setAttribute("transform", `rotate(${-degrees})`);
}

interface Parts {
    frame: SVGGElement | null;
    rotor: SVGGElement | null;
    estimate: SVGGElement | null;
    current: SVGGElement | null;
    length: SVGLineElement | null;
}

function draw(parts: Parts, block: PlayBlock, largestA: number, turning: boolean): void {
    const of = (name: string): number => block.values[name] ?? 0;
    const [q, d, theta] = [of("i_q_a"), of("i_d_a"), of("angle_el_deg")];
    const length = Math.min(Math.hypot(d, q) / largestA, 1) * LONGEST;
    rotate(parts.frame, turning ? -of("angle_estimated_el_deg") : 0);
    rotate(parts.rotor, theta);
    rotate(parts.estimate, of("angle_estimated_el_deg"));
    const isKnown = (block.values["angle_estimated_el_deg"] ?? null) !== null;
    parts.estimate?.setAttribute("visibility", isKnown ? "visible" : "hidden");
    rotate(parts.current, theta + (Math.atan2(q, d) * 180) / Math.PI);
    parts.length?.setAttribute("x2", String(length));
}

function Stator() {
    return (
        <>
            <circle r={RADIUS} class="stator" />
            {[["a", 0], ["b", 120], ["c", 240]].map(([name, at]) => (
                <g key={name} transform={`rotate(${-Number(at)})`}>
                    <line x1={RADIUS - 10} x2={RADIUS} class="phase" />
                    <text x={RADIUS + 12} transform={`rotate(${at} ${RADIUS + 12} 0)`} class="phase-name">{name}</text>
                </g>
            ))}
        </>
    );
}

function Legend({ values, largestA }: { values: PlayBlock["values"]; largestA: number }) {
    const amplitude = Math.hypot(values["i_d_a"] ?? NaN, values["i_q_a"] ?? NaN);
    return (
        <ul class="legend">
            <li><span class="key north" />{`rotor θ ${shown(values["angle_el_deg"], "°")}°`}</li>
            <li><span class="key estimate" />{`estimate θ̂ ${shown(values["angle_estimated_el_deg"], "°")}°`}</li>
            <li>{`error θ − θ̂ ${shown(values["angle_error_el_deg"], "°")}°`}</li>
            <li><span class="key current" />{`current ${shown(amplitude, "A")} A of ${shown(largestA, "A")} A`}</li>
        </ul>
    );
}

function useDrawing(parts: { current: Parts }, player: Player, largestA: number, turning: boolean): void {
    useEffect(() => {
        const update = (): void => {
            if (player.block !== undefined) {
                draw(parts.current, player.block, largestA, turning);
            }
        };
        update();
        return player.track.drawn.add(update);
    }, [player, largestA, turning]);
}

export function MotorDrawing({ player, largestA }: { player: Player; largestA: number }) {
    const parts = useRef<Parts>({ frame: null, rotor: null, estimate: null, current: null, length: null });
    const [turning, setTurning] = useState(false);
    useDrawing(parts, player, largestA, turning);
    const part = (name: Exclude<keyof Parts, "length">) => (element: SVGGElement | null): void => {
        parts.current[name] = element;
    };
    const length = (element: SVGLineElement | null): void => {
        parts.current.length = element;
    };
    return (
        <section class="drawing" aria-label="Rotor and current">
            <svg viewBox="-122 -122 244 244" role="img" aria-label="Rotor, its estimate and the current vector, as electrical angles">
                <g ref={part("frame")}>
                    <Stator />
                    <g ref={part("rotor")}>
                        <rect x={-62} y={-17} width={62} height={34} class="south" />
                        <rect x={0} y={-17} width={62} height={34} class="north" />
                        <text x={44} y={5} class="pole">N</text>
                    </g>
                    <g ref={part("estimate")}><line x1={-RADIUS} x2={RADIUS} class="estimate" /></g>
                    <g ref={part("current")}><line ref={length} class="current" /></g>
                    <circle r={4} class="shaft" />
                </g>
            </svg>
            <Legend values={player.block?.values ?? {}} largestA={largestA} />
            <label>
                <input type="checkbox" checked={turning} onChange={(event) => setTurning(event.currentTarget.checked)} />
                Turn with θ̂
            </label>
        </section>
    );
}
