// SPDX-License-Identifier: MIT
// A run in slices.
import type { Requests, Run, RunHead, RunResult, SignalInfo } from "./protocol.ts";
import type { Block, Core } from "./wasm.ts";
import type { Job } from "./worker.ts";

// Some 20 ms of computing: between two of them a run can be stopped.
const SLICE_TICKS = 8192;

export async function run(core: Core, { choice, signals }: Requests["run"]["given"], job: Job): Promise<Run> {
    const head = core.call<RunHead>("run.start", { ...choice, signals });
    let done = false;
    while (!done) {
        await job.breathe();
        const at = core.call<{ tick: number; done: boolean }>("run.advance", { ticks: SLICE_TICKS });
        done = at.done;
        job.progress(at.tick / head.ticks);
    }
    const column = (name: string): [string, Float32Array] => [
        name,
        core.floats(core.call<Block>("run.column", { signal: name })),
    ];
    return {
        ...core.call<RunResult>("run.result", {}),
        head,
        times: core.doubles(core.call<Block>("run.times", {})),
        columns: Object.fromEntries(signals.map(column)),
        signals: core.call<SignalInfo[]>("run.signals", {}),
    };
}
