// SPDX-License-Identifier: MIT
// A run in slices.
import type { Job } from "./job.ts";
import type { Requests, Run, RunHead, RunResult, SignalInfo } from "./protocol.ts";
import type { Block, Core } from "./wasm.ts";

// Some 20 ms of computing: between two of them a run can be stopped.
const SLICE_TICKS = 8192;
const TRACE_FILE = "/tmp/trace.csv";

async function runToEnd(core: Core, given: object, job: Job): Promise<RunHead> {
    const head = core.call<RunHead>("run.start", given);
    let done = false;
    while (!done) {
        await job.breathe();
        const at = core.call<{ tick: number; done: boolean }>("run.advance", { ticks: SLICE_TICKS });
        done = at.done;
        job.progress(at.tick / head.ticks);
    }
    return head;
}

export async function run(core: Core, { choice, signals }: Requests["run"]["given"], job: Job): Promise<Run> {
    const head = await runToEnd(core, { ...choice, signals }, job);
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

export async function trace(core: Core, { choice }: Requests["trace"]["given"], job: Job): Promise<string> {
    await runToEnd(core, { ...choice, trace: TRACE_FILE }, job);
    return core.take(TRACE_FILE);
}
