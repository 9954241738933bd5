// SPDX-License-Identifier: MIT
// New values of keys that a person has typed and not given to the board yet.
import { useState } from "preact/hooks";

export interface Drafts {
    of(key: string): string;
    type(key: string, text: string): void;
    forget(keys: string[]): void;
    keys: string[]; // that have one
}

export function useDrafts(): Drafts {
    const [texts, setTexts] = useState<Record<string, string>>({});
    return {
        of: (key) => texts[key] ?? "",
        type: (key, text) => setTexts((all) => ({ ...all, [key]: text })),
        forget: (keys) => setTexts((all) => Object.fromEntries(Object.entries(all).filter(([key]) => !keys.includes(key)))),
        keys: Object.entries(texts).filter(([, text]) => text.trim() !== "").map(([key]) => key),
    };
}
