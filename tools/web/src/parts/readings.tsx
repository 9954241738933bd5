// SPDX-License-Identifier: MIT
// Some figures below each other.
import { shown } from "./format.ts";

export interface Reading {
    label: string;
    text: string; // with its unit
    isBad?: boolean;
}

// A signal as a person reads it.
export interface ReadSignal {
    label: string;
    name: string;
    unit: string;
    factor?: number; // from the signal's own unit
}

export function readingsOf(signals: ReadSignal[], values: Record<string, number | null>): Reading[] {
    return signals.map(({ label, name, unit, factor = 1 }) => {
        const value = values[name] ?? null;
        return { label, text: `${shown(value === null ? null : value * factor, unit)} ${unit}` };
    });
}

export function Readings({ caption, rows }: { caption: string; rows: Reading[] }) {
    return (
        <table class="readings">
            <caption>{caption}</caption>
            <tbody>
                {rows.map(({ label, text, isBad = false }) => (
                    <tr key={label} class={isBad ? "broken" : ""}>
                        <th scope="row">{label}</th>
                        <td>{text}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}
