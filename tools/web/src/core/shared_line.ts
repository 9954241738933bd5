// SPDX-License-Identifier: MIT
// The line to a board between the page, which has the port, and the worker, which waits for bytes within a call: memory that both
// share. What the worker writes goes to the page as a message.

const [WRITTEN, TAKEN, CLOSED, STOPS, NEWS] = [0, 1, 2, 3, 4] as const; // counts wrap; NEWS: of all that the worker waits for
const HEAD_WORDS = 5;
const HEAD_BYTES = HEAD_WORDS * Int32Array.BYTES_PER_ELEMENT;
const ROOM = 1 << 20; // a power of two; a second of the fastest line

// Whether the browser lets a page and its worker share memory: only where the server, or the page's own service worker, says
// that nothing of another place is in it.
export function canShare(): boolean {
    return globalThis.crossOriginIsolated === true;
}

// What the simulator asks of the line (host_sim/web/worker_line.cpp).
export interface Line {
    take(to: Uint8Array, waitS: number): number;
    write(bytes: Uint8Array): void;
    nowS(): number;
    takeStop(): boolean;
}

export class SharedLine {
    readonly memory: SharedArrayBuffer;
    private readonly head: Int32Array;
    private readonly ring: Uint8Array;

    constructor(memory = new SharedArrayBuffer(HEAD_BYTES + ROOM)) {
        this.memory = memory;
        this.head = new Int32Array(memory, 0, HEAD_WORDS);
        this.ring = new Uint8Array(memory, HEAD_BYTES);
    }

    // How often a stop was asked for.
    get stops(): number {
        return Atomics.load(this.head, STOPS);
    }

    // Of the page: bytes of the board. What there is no room for is lost, as on any line.
    put(bytes: Uint8Array): void {
        const written = Atomics.load(this.head, WRITTEN);
        const room = ROOM - ((written - Atomics.load(this.head, TAKEN)) >>> 0);
        const count = Math.min(bytes.length, room);
        const at = written & (ROOM - 1);
        const first = Math.min(count, ROOM - at);
        this.ring.set(bytes.subarray(0, first), at);
        this.ring.set(bytes.subarray(first, count), 0);
        Atomics.store(this.head, WRITTEN, (written + count) | 0);
        this.tell();
    }

    // Of the page: no more will come.
    close(): void {
        Atomics.store(this.head, CLOSED, 1);
        this.tell();
    }

    // Of the page: the motor is to stop, whatever is under way.
    askStop(): void {
        Atomics.add(this.head, STOPS, 1);
        this.tell();
    }

    // Of the worker: what has come, `to.length` bytes at most; waits for a first byte, a stop, or the end. -1: the line is closed.
    take(to: Uint8Array, waitMs: number): number {
        const news = Atomics.load(this.head, NEWS);
        const taken = Atomics.load(this.head, TAKEN);
        if (Atomics.load(this.head, WRITTEN) === taken && waitMs > 0 && !this.isClosed()) {
            Atomics.wait(this.head, NEWS, news, waitMs);
        }
        const count = Math.min((Atomics.load(this.head, WRITTEN) - taken) >>> 0, to.length);
        if (count === 0) {
            return this.isClosed() ? -1 : 0;
        }
        const at = taken & (ROOM - 1);
        const first = Math.min(count, ROOM - at);
        to.set(this.ring.subarray(at, at + first));
        to.set(this.ring.subarray(0, count - first), first);
        Atomics.store(this.head, TAKEN, (taken + count) | 0);
        return count;
    }

    private isClosed(): boolean {
        return Atomics.load(this.head, CLOSED) !== 0;
    }

    private tell(): void {
        Atomics.add(this.head, NEWS, 1);
        Atomics.notify(this.head, NEWS);
    }
}
