// SPDX-License-Identifier: MIT
// Where in a TOML text a key stands, and what the table of settings says about it.
import type { Text } from "@codemirror/state";
import type { FileKind, SchemaKey } from "../core/protocol.ts";

export class Keys {
    constructor(private readonly all: SchemaKey[], private readonly kind: FileKind) {}

    // Of the file's kind.
    sections(): string[] {
        return [...new Set(this.own().map(({ section }) => section))];
    }

    in(section: string): SchemaKey[] {
        return this.own().filter((key) => key.section === section);
    }

    // "key" in its section, or "section.key" before the first one.
    find(section: string, written: string): SchemaKey | undefined {
        const name = section === "" ? written : `${section}.${written}`;
        return this.own().find((key) => `${key.section}.${key.key}` === name);
    }

    private own(): SchemaKey[] {
        return this.all.filter(({ kinds }) => kinds.includes(this.kind));
    }
}

// The section that a line belongs to, "" before the first one.
export function sectionAt(text: Text, line: number): string {
    for (let number = line; number >= 1; number--) {
        const header = /^\s*\[\[?\s*([\w.]+)/.exec(text.line(number).text);
        if (header?.[1] !== undefined) {
            return header[1];
        }
    }
    return "";
}

// "0.001 to 50 Ω; default: required": what a person may write.
export function rangeText(key: SchemaKey): string {
    return `${key.allowed}; default: ${key.default}`;
}
