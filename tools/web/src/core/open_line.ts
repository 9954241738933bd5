// SPDX-License-Identifier: MIT
// The line to the board that the worker follows.
import type { ToLine } from "./protocol.ts";
import { type Line, SharedLine } from "./shared_line.ts";
import type { Core } from "./wasm.ts";

const MS_PER_S = 1000;

let shared: SharedLine | undefined;

function lineOn(line: SharedLine): Line {
    let { stops } = line;
    return {
        take: (to, waitS) => line.take(to, waitS * MS_PER_S),
        write: (bytes) => {
            const message: ToLine = { line: bytes.slice() };
            self.postMessage(message, { transfer: [message.line.buffer] });
        },
        nowS: () => performance.now() / MS_PER_S,
        takeStop: () => {
            const isNew = stops !== line.stops;
            stops = line.stops;
            return isNew;
        },
    };
}

export function openLine(core: Core, memory: SharedArrayBuffer): void {
    shared = new SharedLine(memory);
    core.useLine(lineOn(shared));
}

// Whether a stop was asked for since there were so many: what was asked before it is not done after it.
export function isStoppedSince(stops: number): boolean {
    return stops !== shared?.stops;
}
