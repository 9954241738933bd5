// SPDX-License-Identifier: MIT
// What the board does when its PC is gone: it stops the motor after a time, or never. Null: that is not known.
import { shown } from "../parts/format.ts";

export interface Note {
    text: string;
    isBad: boolean;
}

export function noteWhileFollowed(timeoutS: number | null): Note | undefined {
    if (timeoutS === null) {
        return undefined;
    }
    return timeoutS > 0
        ? { text: `Without this page the motor stops after ${shown(timeoutS)} s.`, isBad: false }
        : { text: "The board does not stop by itself when this page is gone: set tuning.command_timeout_s.", isBad: true };
}

export function alertAfterwards(timeoutS: number | null): string {
    if (timeoutS === null) {
        return "The motor may run on. Whether the board stops it by itself is not known.";
    }
    const then = timeoutS > 0 ? `The board stops it after ${shown(timeoutS)} s.` : "The board does not stop it by itself.";
    return `The motor may run on. ${then}`;
}
