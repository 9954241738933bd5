// SPDX-License-Identifier: MIT
// What was asked of a board, and what it and the program have said.

export interface Said {
    kind: "asked" | "answer" | "refusal" | "news";
    text: string;
}

export interface Answer {
    text: string;
    refused: boolean;
}

const SAID_MAX = 500;

export class Dialogue {
    said: Said[] = []; // another array with each change

    add(kind: Said["kind"], ...texts: string[]): void {
        const made = texts.filter((text) => text !== "").map((text): Said => ({ kind, text: text.trimEnd() }));
        if (made.length > 0) {
            this.said = [...this.said, ...made].slice(-SAID_MAX);
        }
    }

    answer({ text, refused }: Answer): void {
        this.add(refused ? "refusal" : "answer", text);
    }
}
