// SPDX-License-Identifier: MIT
// A slider and a field for the same number.
import { useEffect, useId, useState } from "preact/hooks";

interface KnobProps {
    name: string;
    unit: string;
    value: number;
    largest: number; // either way
    step: number;
    isDisabled?: boolean;
    onValue(value: number): void;
    onHold?(isHeld: boolean): void; // whether a person is in the field
}

// The field counts when it is left, or with Enter.
export function Knob({ name, unit, value, largest, step, isDisabled = false, onValue, onHold }: KnobProps) {
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
                id={id} type="number" value={text} min={-largest} max={largest} step="any" disabled={isDisabled}
                onInput={(event) => setText(event.currentTarget.value)} onChange={(event) => take(event.currentTarget.value)}
                onFocus={() => onHold?.(true)} onBlur={() => onHold?.(false)}
            />
            <input
                type="range" aria-label={`${name} slider, in ${unit}`} value={value} min={-largest} max={largest} step={step}
                disabled={isDisabled} onInput={(event) => take(event.currentTarget.value)}
            />
        </div>
    );
}
