// SPDX-License-Identifier: MIT
// Numbers for people, and files for their disks.

export function shown(value: number | null | undefined): string {
    return value === null || value === undefined || Number.isNaN(value) ? "–" : String(Number(value.toPrecision(5)));
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
