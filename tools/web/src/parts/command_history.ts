// SPDX-License-Identifier: MIT
// A line that a person writes, and the lines before it, as in a terminal.
import { useRef, useState } from "preact/hooks";

export interface CommandHistory {
    text: string;
    set(text: string): void;
    last(): string; // empty: there is none
    keep(line: string): void; // and begins a new one
    recall(by: number): void;
}

export function useCommandHistory(): CommandHistory {
    const [text, set] = useState("");
    const lines = useRef<string[]>([]);
    const at = useRef(0); // its length: the new line
    const last = (): string => lines.current.at(-1) ?? "";
    return {
        text, set, last,
        keep: (line) => {
            lines.current = last() === line ? lines.current : [...lines.current, line];
            at.current = lines.current.length;
            set("");
        },
        recall: (by) => {
            at.current = Math.min(Math.max(at.current + by, 0), lines.current.length);
            set(lines.current[at.current] ?? "");
        },
    };
}
