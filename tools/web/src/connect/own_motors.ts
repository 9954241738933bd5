// SPDX-License-Identifier: MIT
// Motor files of the person: what was measured or adopted here. Whichever board is connected next, its name leads to them as to
// the shipped ones, until the page is loaded anew.
const texts: Record<string, string> = {};

export function ownMotors(): Record<string, string> {
    return { ...texts };
}

export function keepMotor(name: string, text: string): void {
    texts[name] = text;
}

function asFileName(title: string): string {
    return title.toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_+|_+$/g, "");
}

// No shipped file has such a name. Of a motor that is measured again the newer file counts.
export function nameOfMeasured(motor: string): string {
    return `${asFileName(motor)}_measured`;
}

// Of a file that a person has chosen.
export function nameOfFile(file: string): string {
    return asFileName(file.replace(/\.toml$/i, "")) || "motor";
}
