// SPDX-License-Identifier: MIT
// What a drive is to follow: a speed, a position or a torque.
import type { PlayMode } from "../core/protocol.ts";
import { Knob } from "./knob.tsx";

interface Props {
    mode: PlayMode;
    value: number | undefined; // undefined: not known yet
    largest: Record<PlayMode, number>; // either way
    note?: string;
    onMode(mode: PlayMode): void;
    onValue(value: number): void;
    onHold?(isHeld: boolean): void; // whether a person is in the field
}

interface Mode {
    name: string;
    unit: string;
    step?: number; // without one it is a hundredth of the largest
}

const MODES: Record<PlayMode, Mode> = {
    speed: { name: "Speed", unit: "rpm", step: 10 },
    position: { name: "Position", unit: "°", step: 5 },
    torque: { name: "Torque command", unit: "N·m" },
};

function hundredth(largest: number): number {
    return Number((largest / 100).toPrecision(2));
}

export function CommandChoice({ mode, value, largest, note, onMode, onValue, onHold }: Props) {
    const { name, unit, step } = MODES[mode];
    return (
        <fieldset>
            <legend>Command</legend>
            <div class="choices">
                {(Object.keys(MODES) as PlayMode[]).map((each) => (
                    <label key={each}>
                        <input type="radio" name="mode" checked={mode === each} onChange={() => onMode(each)} />
                        {each}
                    </label>
                ))}
            </div>
            <Knob
                name={name} unit={unit} value={value ?? 0} largest={largest[mode]} step={step ?? hundredth(largest[mode])} isDisabled={value === undefined}
                onValue={onValue} {...(onHold && { onHold })}
            />
            {note !== undefined && <p class="note">{note}</p>}
        </fieldset>
    );
}
