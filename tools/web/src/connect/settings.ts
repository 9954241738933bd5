// SPDX-License-Identifier: MIT
// What a connection is made with, as a person has typed it.
import type { BoardFiles, LiveOptions } from "../core/protocol.ts";

export type NumberName = "baud" | "keep_s" | "pace";

export interface NumberField {
    label: string;
    unit: string;
    least: number;
    most: number;
    empty?: string; // what an empty field stands for
}

export const NUMBERS: Record<NumberName, NumberField> = {
    baud: { label: "Baud rate", unit: "baud", least: 1200, most: 12_000_000, empty: "automatic" },
    keep_s: { label: "Seconds kept for a recording", unit: "s", least: 0.1, most: 60 },
    pace: { label: "Board's time ×", unit: "", least: 0.001, most: 1000 },
};

export interface Settings {
    files: BoardFiles;
    numbers: Record<NumberName, string>;
}

export const FIRST_SETTINGS: Settings = {
    files: { motor: "", board: "", tuning: "" }, // as the board says
    numbers: { baud: "", keep_s: "10", pace: "1" },
};

export interface Connection {
    baud: number | undefined; // undefined: one of the known rates
    options: LiveOptions;
}

// Throws for a number that is none, or out of its range.
function numberOf({ numbers }: Settings, name: NumberName): number {
    const { label, unit, least, most } = NUMBERS[name];
    const value = Number(numbers[name]);
    if (numbers[name].trim() === "" || !(value >= least && value <= most)) {
        throw new Error(`${label} = "${numbers[name]}"; allowed: ${`${least} to ${most} ${unit}`.trimEnd()}`);
    }
    return value;
}

function baudOf(settings: Settings): number | undefined {
    if (settings.numbers.baud.trim() === "") {
        return undefined;
    }
    const baud = numberOf(settings, "baud");
    if (!Number.isInteger(baud)) {
        throw new Error(`${NUMBERS.baud.label} = ${baud}; allowed: whole numbers`);
    }
    return baud;
}

export function connectionOf(settings: Settings): Connection {
    const options = { files: settings.files, pace: numberOf(settings, "pace"), keep_s: numberOf(settings, "keep_s") };
    return { baud: baudOf(settings), options };
}
