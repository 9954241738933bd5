// SPDX-License-Identifier: MIT
// What a person does to the machine: requests, commands, load, and what breaks it.
import type { Knobs, PlayAct, PlayHead, PlayMode } from "../core/protocol.ts";
import { CommandChoice } from "../parts/command_choice.tsx";
import { Knob } from "../parts/knob.tsx";
import { Requests } from "../parts/requests.tsx";

interface Props {
    head: PlayHead;
    knobs: Knobs;
    act(act: PlayAct): void;
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
    const command = (mode: PlayMode, value: number): void => act({ call: "command", mode, value });
    return (
        <section class="controls" aria-label="Controls">
            <Requests ask={(what) => act({ call: "request", what })} />
            <CommandChoice
                mode={knobs.mode} value={knobs.command}
                largest={{ speed: head.limits.speed_rpm, position: head.limits.position_deg, torque: head.limits.torque_nm }}
                onMode={(mode) => command(mode, 0)} onValue={(value) => command(knobs.mode, value)}
            />
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
