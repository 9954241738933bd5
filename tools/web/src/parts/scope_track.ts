// SPDX-License-Identifier: MIT
// What rolling scopes show: the newest points, and the states and faults behind them.
import type { PlayBlock, ScopeChoice } from "../core/protocol.ts";
import type { Band } from "./bands.ts";
import { Listeners } from "./listeners.ts";
import { Rolling } from "./rolling.ts";
import type { ScopePicture } from "./rolling_scope.tsx";

const SCOPE_POINTS = 840; // two a bucket, 400 buckets a span, and some more

export type ScopeBlock = Pick<PlayBlock, "time_s" | "state" | "fault" | "times" | "columns">;

export class ScopeTrack {
    readonly drawn = new Listeners(); // called when there is something new to draw
    private rolling: Rolling;
    private bands: Band[] = [];
    private now: number | undefined;
    private isBroken = false;

    constructor(private scope: ScopeChoice) {
        this.rolling = new Rolling(scope.signals, SCOPE_POINTS);
    }

    setScope(scope: ScopeChoice): void {
        this.scope = scope;
        this.rolling = new Rolling(scope.signals, SCOPE_POINTS);
    }

    take(block: ScopeBlock): void {
        if (block.time_s < (this.now ?? 0)) { // what is watched has begun anew
            this.setScope(this.scope);
            this.bands = [];
        }
        if (block.time_s !== this.now) {
            this.mark(block);
        }
        this.now = block.time_s;
        this.rolling.append(block.times, block.columns);
    }

    // What comes next is not known to go on from what was there: its state has a ground of its own.
    breakOff(): void {
        this.isBroken = true;
    }

    picture(names: string[]): ScopePicture {
        return { data: this.rolling.data(names), now: this.now ?? 0, bands: this.bands };
    }

    // States as grounds, faults as lines; what has left the screen is forgotten.
    private mark({ time_s: at, state, fault }: ScopeBlock): void {
        const last = this.bands.filter(({ kind }) => kind === "state").at(-1);
        const isNew = last === undefined || last.label !== state || this.isBroken;
        if (last !== undefined && !this.isBroken) {
            last.to = at;
        }
        this.isBroken = false;
        const made: Band[] = isNew ? [{ from: at, to: at, label: state, kind: "state" }] : [];
        if (isNew && fault !== null) {
            made.push({ from: fault.time_s, to: fault.time_s, label: fault.name, kind: "fault" });
        }
        this.bands = [...this.bands, ...made].filter(({ to }) => to >= at - this.scope.span_s);
    }
}
