// SPDX-License-Identifier: MIT
// A running board at a serial line. Each call follows it for some hundredths of a second; between two calls other requests come in.
import { isStoppedSince, openLine } from "./open_line.ts";
import type { LiveBlock, LiveHead, LiveKey, Requests, Said, ScopeChoice, SignalInfo } from "./protocol.ts";
import type { Block, Core } from "./wasm.ts";

type Given<Name extends keyof Requests> = Requests[Name]["given"];

const RECORDING = "field.log";

export function liveOpen(core: Core, { line, motors, options, scope }: Given<"liveOpen">): LiveHead {
    core.addMotors(motors);
    openLine(core, line);
    return core.call("live.open", { ...options, ...scope });
}

export function liveHead(core: Core): LiveHead {
    return core.call("live.head", {});
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

export function liveExecute(core: Core, { line, stops }: Given<"liveExecute">): Said {
    return isStoppedSince(stops)
        ? { text: `${line}: not done, a stop came before its turn`, refused: true }
        : core.call("live.execute", { line });
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
