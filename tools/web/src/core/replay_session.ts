// SPDX-License-Identifier: MIT
// A recording of the flight recorder.
import type { Curves, ReplayHead, Requests } from "./protocol.ts";
import type { Block, Core } from "./wasm.ts";

export function replayOpen(core: Core, { name, bytes }: Requests["replayOpen"]["given"]): ReplayHead {
    return core.callWithFile("replay.open", name, bytes);
}

export function replayHead(core: Core): ReplayHead | null {
    return core.call("replay.head", {});
}

// As the simulator has it: columns lie in its memory.
type Answer = Omit<Curves, "times" | "columns"> & { times: Block; columns: Record<string, Block> };

export function replayColumns(core: Core, given: Requests["replayColumns"]["given"]): Curves {
    const answer = core.call<Answer>("replay.columns", given);
    return { ...answer, times: core.doubles(answer.times), columns: core.columns(answer.columns) };
}
