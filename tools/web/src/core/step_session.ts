// SPDX-License-Identifier: MIT
// The stepper. A command that lets many ticks go by comes in slices, between which it can be stopped.
import type { Job } from "./job.ts";
import type { Requests, StepHead, StepView } from "./protocol.ts";
import type { Core } from "./wasm.ts";

export function stepOpen(core: Core, { source, choice }: Requests["stepOpen"]["given"]): StepHead {
    return core.call("step.open", { source, ...choice });
}

interface Slice {
    text: string;
    refused: boolean;
    rest: string; // the command that does what is left; empty: nothing is
    tick: number;
}

export async function stepExecute(
    core: Core, { line }: Requests["stepExecute"]["given"], job: Job,
): Promise<Requests["stepExecute"]["back"]> {
    let slice = core.call<Slice>("step.execute", { line });
    while (slice.rest !== "") {
        job.progress(slice.tick);
        await job.breathe();
        slice = core.call<Slice>("step.execute", { line: slice.rest });
    }
    return { text: slice.text, refused: slice.refused };
}

export function stepComplete(core: Core, given: Requests["stepComplete"]["given"]): string[] {
    return core.call("step.complete", given);
}

export function stepLook(core: Core): StepView {
    return core.call("step.look", {});
}
