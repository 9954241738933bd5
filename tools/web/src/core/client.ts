// SPDX-License-Identifier: MIT
// The page's side of the worker: a promise a request.
import type { Answer, Cancel, Request, RequestName, Requests, ToLine } from "./protocol.ts";

export class Stopped extends Error {}

// A request that is under way.
export interface Pending<Value> {
    done: Promise<Value>; // rejects with Stopped after stop()
    stop(): void;
}

interface Waiting {
    resolve(value: unknown): void;
    reject(error: Error): void;
    progress(share: number): void;
}

export class Client {
    private readonly worker = new Worker(new URL("./worker.js", document.baseURI), { type: "module" });
    private readonly waiting = new Map<number, Waiting>();
    private last = 0;

    // `toLine` takes what the worker writes to a board.
    constructor(toLine: (bytes: Uint8Array) => void = () => undefined) {
        this.worker.onmessage = ({ data }: MessageEvent<Answer | ToLine>) => ("line" in data ? toLine(data.line) : this.take(data));
        this.worker.onerror = ({ message }) => this.fail(`the simulator could not be loaded: ${message}`);
    }

    begin<Name extends RequestName>(
        name: Name,
        given: Requests[Name]["given"],
        progress: (share: number) => void = () => undefined,
    ): Pending<Requests[Name]["back"]> {
        const id = ++this.last;
        const done = new Promise<unknown>((resolve, reject) => {
            this.waiting.set(id, { resolve, reject, progress });
        }) as Promise<Requests[Name]["back"]>;
        const request: Request<Name> = { id, name, given };
        this.worker.postMessage(request);
        const cancel: Cancel = { cancel: id };
        return { done, stop: () => this.worker.postMessage(cancel) };
    }

    ask<Name extends RequestName>(name: Name, given: Requests[Name]["given"]): Promise<Requests[Name]["back"]> {
        return this.begin(name, given).done;
    }

    // Whatever is under way ends with an error.
    end(): void {
        this.worker.terminate();
        this.fail("the simulator was ended");
    }

    private take(answer: Answer): void {
        const waiting = this.waiting.get(answer.id);
        if ("progress" in answer) {
            waiting?.progress(answer.progress);
            return;
        }
        this.waiting.delete(answer.id);
        if ("error" in answer) {
            waiting?.reject(answer.cancelled ? new Stopped(answer.error) : new Error(answer.error));
        } else {
            waiting?.resolve(answer.value);
        }
    }

    private fail(text: string): void {
        for (const waiting of this.waiting.values()) {
            waiting.reject(new Error(text));
        }
        this.waiting.clear();
    }
}
