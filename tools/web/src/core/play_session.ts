// SPDX-License-Identifier: MIT
// The machine that is played with. Time goes by as the page asks for it: a frame of the screen, a call.
import type { Knobs, PlayAct, PlayBlock, PlayHead, Requests, ScopeChoice } from "./protocol.ts";
import type { Block, Core } from "./wasm.ts";

type Given<Name extends keyof Requests> = Requests[Name]["given"];

export function playStart(core: Core, { choice, scope }: Given<"playStart">): PlayHead {
    return core.call("play.start", { ...choice, ...scope });
}

export function playHead(core: Core): PlayHead | null {
    return core.call("play.head", {});
}

export function playScope(core: Core, choice: ScopeChoice): null {
    return core.call("play.scope", choice);
}

export function playAct(core: Core, act: PlayAct): Knobs {
    return core.call(`play.${act.call}`, act);
}

// As the simulator has it: columns lie in its memory.
type Answer = Omit<PlayBlock, "times" | "columns"> & { times: Block; columns: Record<string, Block> };

export function playAdvance(core: Core, given: Given<"playAdvance">): PlayBlock {
    const answer = core.call<Answer>("play.advance", given);
    return { ...answer, times: core.doubles(answer.times), columns: core.columns(answer.columns) };
}
