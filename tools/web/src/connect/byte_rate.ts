// SPDX-License-Identifier: MIT
// How many bytes come in a second, over the last whole second.

const WINDOW_MS = 1000;

export class ByteRate {
    perS = 0;
    private from: { ms: number; bytes: number } | undefined;

    take(bytes: number): void {
        const ms = performance.now();
        this.from ??= { ms, bytes };
        const passed = ms - this.from.ms;
        if (passed >= WINDOW_MS) {
            this.perS = ((bytes - this.from.bytes) * 1000) / passed;
            this.from = { ms, bytes };
        }
    }
}
