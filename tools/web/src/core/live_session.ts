// SPDX-License-Identifier: MIT
// A running board at a serial line. Each call follows it for some hundredths of a second; between two calls other requests come in.
import type { LiveBlock, LiveHead, LiveKey, Requests, Said, ScopeChoice, SignalInfo, ToLine } from "./protocol.ts";
import { type Line, SharedLine } from "./shared_line.ts";
import type { Block, Core } from "./wasm.ts";

type Given<Name extends keyof Requests> = Requests[Name]["given"];

const RECORDING = "field.log";
const MS_PER_S = 1000;

let shared: SharedLine | undefined; // of the board that is followed

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

export function liveOpen(core: Core, { line, options, scope }: Given<"liveOpen">): LiveHead {
    shared = new SharedLine(line);
    core.useLine(lineOn(shared));
    return core.call("live.open", { ...options, ...scope });
}

export function liveSignals(core: Core): SignalInfo[] | null {
    return core.call("live.signals", {});
}

export function liveScope(core: Core, choice: ScopeChoice): null {
    return core.call("live.scope", choice);
}

// As the simulator has it: columns lie in its memory.
type Answer = Omit<LiveBlock, "times" | "columns"> & { times: Block; columns: Record<string, Block> };

export function livePass(core: Core, given: Given<"livePass">): LiveBlock {
    const answer = core.call<Answer>("live.pass", given);
    return { ...answer, times: core.doubles(answer.times), columns: core.columns(answer.columns) };
}

// What was asked before a stop is not done after it.
export function liveExecute(core: Core, { line, stops }: Given<"liveExecute">): Said {
    return stops === shared?.stops
        ? core.call("live.execute", { line })
        : { text: `${line}: not done, a stop came before its turn`, refused: true };
}

export function liveKeys(core: Core): LiveKey[] {
    return core.call("live.keys", {});
}

export function liveRecord(core: Core): Requests["liveRecord"]["back"] {
    const text = core.call<string>("live.record", { file: RECORDING });
    return { text, log: core.take(RECORDING) };
}

export function liveClose(core: Core): string {
    return core.call("live.close", {});
}
