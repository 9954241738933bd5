// SPDX-License-Identifier: MIT
// What was asked of a board, and what it and the program have said.
import type { Said } from "../core/protocol.ts";

export interface Line {
    kind: "asked" | "answer" | "refusal" | "news";
    text: string;
}

const LINES_MAX = 500;

export class Dialogue {
    lines: Line[] = []; // another array with each change

    add(kind: Line["kind"], ...texts: string[]): void {
        const made = texts.filter((text) => text !== "").map((text): Line => ({ kind, text: text.trimEnd() }));
        if (made.length > 0) {
            this.lines = [...this.lines, ...made].slice(-LINES_MAX);
        }
    }

    answer({ text, refused }: Said): void {
        this.add(refused ? "refusal" : "answer", text);
    }
}
