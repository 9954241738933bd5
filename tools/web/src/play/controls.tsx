// SPDX-License-Identifier: MIT
// What a person does to the machine: requests, commands, load, and what breaks it.
import { useEffect, useId, useState } from "preact/hooks";
import type { Knobs, PlayAct, PlayHead, PlayMode } from "../core/protocol.ts";

interface Props {
    head: PlayHead;
    knobs: Knobs;
    act(act: PlayAct): void;
}

interface KnobProps {
    name: string;
    unit: string;
    value: number;
    largest: number; // either way
    step: number;
    onValue(value: number): void;
}

// A slider and a field for the same number. The field counts when it is left, or with Enter.
function Knob({ name, unit, value, largest, step, onValue }: KnobProps) {
    const id = useId();
    const [text, setText] = useState(String(value));
    useEffect(() => setText(String(value)), [value]);
    const take = (given: string): void => {
        setText(given);
        if (given.trim() !== "" && Number.isFinite(Number(given))) {
            onValue(Number(given));
        } else {
            setText(String(value));
        }
    };
    return (
        <div class="knob">
            <label for={id}>{`${name} [${unit}]`}</label>
            <input
                id={id} type="number" value={text} min={-largest} max={largest} step="any"
                onInput={(event) => setText(event.currentTarget.value)} onChange={(event) => take(event.currentTarget.value)}
            />
            <input
                type="range" aria-label={`${name} slider, in ${unit}`} value={value} min={-largest} max={largest} step={step}
                onInput={(event) => take(event.currentTarget.value)}
            />
        </div>
    );
}

function Requests({ act }: Props) {
    const ask = (what: "run" | "stop" | "clear") => () => act({ call: "request", what });
    return (
        <div class="buttons" role="group" aria-label="Requests">
            <button type="button" class="main" onClick={ask("run")}>Run</button>
            <button type="button" onClick={ask("stop")}>Stop</button>
            <button type="button" onClick={ask("clear")}>Clear fault</button>
        </div>
    );
}

const MODES: Record<PlayMode, { unit: string; step: number }> = {
    speed: { unit: "rpm", step: 10 },
    position: { unit: "°", step: 5 },
};

function Command({ head, knobs, act }: Props) {
    const { mode } = knobs;
    const { unit, step } = MODES[mode];
    const largest = mode === "speed" ? head.limits.speed_rpm : head.limits.position_deg;
    const set = (next: PlayMode, value: number): void => act({ call: "command", mode: next, value });
    return (
        <fieldset>
            <legend>Command</legend>
            <div class="choices">
                {(Object.keys(MODES) as PlayMode[]).map((name) => (
                    <label key={name}>
                        <input type="radio" name="mode" checked={mode === name} onChange={() => set(name, 0)} />
                        {name}
                    </label>
                ))}
            </div>
            <Knob
                name={mode === "speed" ? "Speed" : "Position"} unit={unit} value={knobs.command} largest={largest} step={step}
                onValue={(value) => set(mode, value)}
            />
        </fieldset>
    );
}

interface Breakage {
    what: string; // a word of [[scenario.fault]]
    label: string;
    value: number | null;
    lasts: boolean;
}

const JUMP_DEG = 90;
const DIP = 0.4; // of the nominal bus voltage

function breakages({ bus_v: bus, has_sensor: hasSensor }: PlayHead): Breakage[] {
    const lasting = (what: string, label: string, value: number | null = null): Breakage => ({ what, label, value, lasts: true });
    const dip = Number((bus * DIP).toPrecision(3));
    return [
        lasting("phase_a_open", "Open phase a"),
        lasting("phase_b_open", "Open phase b"),
        lasting("phase_c_open", "Open phase c"),
        lasting("adc_a_stuck", "Stuck current sensor a"),
        lasting("adc_b_stuck", "Stuck current sensor b"),
        ...(hasSensor ? [lasting("angle_stuck", "Stuck angle sensor")] : []),
        lasting("rotor_blocked", "Blocked rotor"),
        lasting("bus_voltage", `Bus dip to ${dip} V`, dip),
        { what: "rotor_jump", label: `Rotor jump by ${JUMP_DEG}°`, value: JUMP_DEG, lasts: false },
    ];
}

function Breakages({ head, knobs, act }: Props) {
    return (
        <fieldset>
            <legend>Break it</legend>
            <div class="buttons">
                {breakages(head).map(({ what, label, value, lasts }) => {
                    const broken = knobs.broken.includes(what);
                    return (
                        <button
                            type="button" key={what} class="small" onClick={() => act({ call: broken ? "repair" : "break", what, value })}
                            {...(lasts ? { "aria-pressed": broken } : {})}
                        >
                            {label}
                        </button>
                    );
                })}
            </div>
            {!head.has_sensor && <p class="note">This drive has no angle sensor.</p>}
        </fieldset>
    );
}

export function Controls(props: Props) {
    const { head, knobs, act } = props;
    return (
        <section class="controls" aria-label="Controls">
            <Requests {...props} />
            <Command {...props} />
            <fieldset>
                <legend>Load</legend>
                <Knob
                    name="Load torque" unit="N·m" value={knobs.load_nm} largest={head.limits.load_nm}
                    step={Number((head.limits.load_nm / 100).toPrecision(2))} onValue={(value) => act({ call: "load", value })}
                />
            </fieldset>
            <Breakages {...props} />
        </section>
    );
}
