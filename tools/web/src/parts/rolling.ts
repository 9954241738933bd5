// SPDX-License-Identifier: MIT
// The last so many points of some curves; older ones fall out.

export class Rolling {
    private readonly times: Float64Array;
    private readonly columns: Map<string, Float32Array>;
    private from = 0;
    private to = 0;

    constructor(names: string[], private readonly points: number) {
        const room = 2 * points; // so that what is kept moves seldom
        this.times = new Float64Array(room);
        this.columns = new Map(names.map((name) => [name, new Float32Array(room)]));
    }

    append(times: Float64Array, columns: Record<string, Float32Array>): void {
        const skipped = Math.max(0, times.length - this.points);
        const count = times.length - skipped;
        this.makeRoom(count);
        this.times.set(times.subarray(skipped), this.to);
        for (const [name, values] of this.columns) {
            const column = columns[name];
            values.set(column === undefined ? new Float32Array(count).fill(NaN) : column.subarray(skipped), this.to);
        }
        this.to += count;
        this.from = Math.max(this.from, this.to - this.points);
    }

    // Of these names, as a plot takes them. Good until the next append.
    data(names: string[]): [Float64Array, ...Float32Array[]] {
        const part = (name: string): Float32Array =>
            this.columns.get(name)?.subarray(this.from, this.to) ?? new Float32Array(this.to - this.from).fill(NaN);
        return [this.times.subarray(this.from, this.to), ...names.map(part)];
    }

    private makeRoom(count: number): void {
        if (this.to + count > this.times.length) {
            const from = Math.max(this.from, this.to - this.points);
            for (const all of [this.times, ...this.columns.values()]) {
                all.copyWithin(0, from, this.to);
            }
            this.to -= from;
            this.from = 0;
        }
    }
}
