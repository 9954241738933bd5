// SPDX-License-Identifier: MIT
// The worker: it holds the simulator, takes requests one after the other, and lets a long one be stopped between slices.
import * as setup from "./board_setup.ts";
import type { Job } from "./job.ts";
import type { Answer, Cancel, Names, Request, RequestName, Requests, SchemaKey } from "./protocol.ts";
import * as live from "./live_session.ts";
import * as play from "./play_session.ts";
import * as replay from "./replay_session.ts";
import { run, trace } from "./run_session.ts";
import * as step from "./step_session.ts";
import { Core, type Module } from "./wasm.ts";

class Stopped extends Error {}

type Handlers = {
    [Name in RequestName]: (
        core: Core,
        given: Requests[Name]["given"],
        job: Job,
    ) => Requests[Name]["back"] | Promise<Requests[Name]["back"]>;
};

const handlers: Handlers = {
    load: (core) => ({
        names: core.call<Names>("config.names", {}),
        schema: core.call<SchemaKey[]>("config.schema", {}),
    }),
    readFile: (core, { path }) => core.read(path),
    writeFiles: (core, { files }) => {
        core.writeFiles(files);
        return null;
    },
    parts: (core, choice) => core.call("config.parts", choice),
    check: (core, { kind, file, text, choice }) => {
        const own = core.call<Requests["check"]["back"]>("config.check", { kind, file, text });
        return own.length > 0 || choice === null ? own : core.call("config.check_all", { ...choice, file });
    },
    run,
    trace,
    ...play,
    ...step,
    ...replay,
    ...live,
    ...setup,
};

const cancelled = new Set<number>();
let core: Promise<Core> | undefined;
let queue: Promise<void> = Promise.resolve();

async function loadCore(): Promise<Core> {
    // By a name that the bundler does not follow: the two files lie beside the worker.
    const glue = new URL("./bench.mjs", self.location.href).href;
    const { default: create } = (await import(glue)) as {
        default: (options: object) => Promise<Module>;
    };
    return new Core(await create({ locateFile: (name: string) => new URL(name, self.location.href).href }));
}

function answer(message: Answer, transfer: Transferable[] = []): void {
    self.postMessage(message, { transfer });
}

// The numbers of an answer move instead of being copied.
function buffersOf(value: unknown): Transferable[] {
    if (ArrayBuffer.isView(value)) {
        return [value.buffer as ArrayBuffer];
    }
    return value !== null && typeof value === "object" ? Object.values(value).flatMap(buffersOf) : [];
}

// A task of its own, unlike a promise, lets the messages in that wait.
function nextTask(): Promise<void> {
    return new Promise((resolve) => {
        const { port1, port2 } = new MessageChannel();
        port1.onmessage = () => {
            port1.close();
            resolve();
        };
        port2.postMessage(null);
    });
}

async function serve<Name extends RequestName>({ id, name, given }: Request<Name>): Promise<void> {
    const stopIfCancelled = (): void => {
        if (cancelled.delete(id)) {
            throw new Stopped("stopped");
        }
    };
    const job: Job = {
        progress: (share) => answer({ id, progress: share }),
        breathe: async () => {
            await nextTask();
            stopIfCancelled();
        },
    };
    try {
        stopIfCancelled();
        core ??= loadCore();
        const value = await handlers[name](await core, given, job);
        answer({ id, value }, buffersOf(value));
    } catch (error) {
        const text = error instanceof Error ? error.message : String(error);
        answer({ id, error: text, cancelled: error instanceof Stopped });
    }
}

self.onmessage = ({ data }: MessageEvent<Request | Cancel>): void => {
    if ("cancel" in data) {
        cancelled.add(data.cancel);
    } else {
        queue = queue.then(() => serve(data));
    }
};
