// SPDX-License-Identifier: MIT
// A name plate as a person types it, and as the file of it that the program reads.
import type { GivenFile, Plate, SchemaKey } from "../core/protocol.ts";

export type PlateKey = keyof Omit<Plate, "demands">;
export type PlateFields = Record<PlateKey, string>;

export interface PlateField {
    key: PlateKey;
    label: string;
    unit: string;
    isOptional?: boolean;
}

export const PLATE_FIELDS: PlateField[] = [
    { key: "name", label: "Name", unit: "" },
    { key: "pole_pairs", label: "Pole pairs", unit: "" },
    { key: "max_speed_rpm", label: "Largest speed", unit: "rpm" },
    { key: "continuous_current_a", label: "Continuous current, peak", unit: "A" },
    { key: "max_current_a", label: "Largest current, peak", unit: "A" },
    { key: "thermal_time_constant_s", label: "Thermal time constant", unit: "s", isOptional: true },
];

export const EMPTY_PLATE = Object.fromEntries(PLATE_FIELDS.map(({ key }) => [key, ""])) as PlateFields;

const FILE = "plate.toml";
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

export function schemaOf(schema: SchemaKey[], name: PlateKey): SchemaKey | undefined {
    return schema.find(({ section, key }) => section === "motor" && key === name);
}

// The line of a field. What is no value at all is refused here, all else by the program.
function lineOf({ key, label, isOptional }: PlateField, text: string, schema: SchemaKey[]): string {
    if (text === "" && isOptional) {
        return "";
    }
    const isName = key === "name";
    if (text === "" || (!isName && !NUMBER.test(text))) {
        throw new Error(`${label}, motor.${key} = "${text}"; allowed: ${schemaOf(schema, key)?.allowed ?? "a number"}`);
    }
    return `${key} = ${isName ? JSON.stringify(text) : Number(text)}\n`;
}

// Throws what is wrong, in one line.
export function plateFile(fields: PlateFields, schema: SchemaKey[]): GivenFile {
    const lines = PLATE_FIELDS.map((field) => lineOf(field, fields[field.key].trim(), schema));
    return { name: FILE, bytes: new TextEncoder().encode(`[motor]\n${lines.join("")}`) };
}

export function fieldsOf(plate: Plate): PlateFields {
    return Object.fromEntries(PLATE_FIELDS.map(({ key }) => [key, String(plate[key])])) as PlateFields;
}
