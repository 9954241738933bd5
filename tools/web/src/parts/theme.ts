// SPDX-License-Identifier: MIT
// Which colours the page has. What draws by itself asks for the tokens of style.css and draws anew when they change.

export const THEMES = ["system", "light", "dark"] as const;
export type Theme = (typeof THEMES)[number];

const changes = new EventTarget();
const CHANGE = "change";

matchMedia("(prefers-color-scheme: dark)").addEventListener(CHANGE, () => changes.dispatchEvent(new Event(CHANGE)));

export function setTheme(theme: Theme): void {
    document.documentElement.dataset["theme"] = theme;
    changes.dispatchEvent(new Event(CHANGE));
}

// The value of a token, as it is now.
export function token(name: string): string {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Until the signal is aborted.
export function onThemeChange(act: () => void, signal: AbortSignal): void {
    changes.addEventListener(CHANGE, act, { signal });
}
