// SPDX-License-Identifier: MIT
// Numbers for people, and files for their disks.

// Decimals that are worth reading. What a simulated motor at rest has beyond them is rounding: -3e-60 rpm.
const DECIMALS: Record<string, number> = {
    rpm: 2, "°": 2, deg: 2, "%": 3, A: 4, V: 3, "N·m": 4, "N m": 4, rad: 4,
};
const DIGITS = 5;
const NOISE = 1e-12; // of any other unit, below each inductance in H and each inertia in kg·m²

export function significant(value: number, digits: number): string {
    return String(Math.abs(value) < NOISE ? 0 : Number(value.toPrecision(digits)));
}

export function shown(value: number | null | undefined, unit = ""): string {
    if (value === null || value === undefined || Number.isNaN(value)) {
        return "–";
    }
    const decimals = DECIMALS[unit];
    return significant(decimals === undefined ? value : Number(value.toFixed(decimals)), DIGITS);
}

export function withUnit(value: string, unit: string): string {
    return unit === "" ? value : `${value} ${unit}`;
}

export function download(name: string, content: Blob): void {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(content);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// The unit at the end of a figure's or a signal's name.
const UNITS: Record<string, string> = {
    rpm: "rpm", pct: "%", deg: "°", a: "A", v: "V", s: "s", rad: "rad", nm: "N·m", hz: "Hz", ohm: "Ω", h: "H", wb: "Wb",
    c: "°C", m2: "kg·m²",
};

export function unitOfName(name: string): string {
    return UNITS[name.slice(name.lastIndexOf("_") + 1)] ?? "";
}
