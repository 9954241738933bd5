// SPDX-License-Identifier: MIT
// Lets time go by for the machine, a block of ticks for each frame of the screen. The worker computes a block while the page
// draws the one before it; when it is late, time goes by more slowly and the page stays quick.
import type { Client } from "../core/client.ts";
import type { Knobs, PlayAct, PlayBlock, ScopeChoice } from "../core/protocol.ts";
import { ScopeTrack } from "../parts/scope_track.ts";
import { SHOWN } from "./shown.ts";

const BLOCK_MAX_S = 0.1; // longer pauses of the page do not count as time
const FRAME_MS = 1000 / 60;
const WINDOW_MS = 1000; // of the figures of speed

export interface Pace {
    ratio: number; // to real time, over the last second
    frames: number; // a second
    dropped: number; // since the machine is there
}

export class Player {
    pace: Pace = { ratio: 0, frames: 0, dropped: 0 };
    block: PlayBlock | undefined;
    slowness = 1; // how many times slower than real time
    readonly track: ScopeTrack;
    private running = false;
    private waiting = false;
    private lastFrame = 0;
    private owed = 0; // ticks, with their fraction
    private window = { from: 0, time_s: 0, frames: 0 };

    constructor(
        private readonly client: Client,
        private readonly periodS: number,
        scope: ScopeChoice,
        private readonly failed: (error: Error) => void,
    ) {
        this.track = new ScopeTrack(scope);
    }

    get isRunning(): boolean {
        return this.running;
    }

    run(): void {
        if (!this.running) {
            this.running = true;
            this.lastFrame = 0;
            requestAnimationFrame(this.frame);
        }
    }

    pause(): void {
        this.running = false;
    }

    async setScope(scope: ScopeChoice): Promise<void> {
        await this.client.ask("playScope", scope);
        this.track.setScope(scope);
    }

    // What it changes shows after a tick, also while time stands still.
    async act(act: PlayAct): Promise<Knobs> {
        const knobs = await this.client.ask("playAct", act);
        if (!this.running) {
            this.take(await this.client.ask("playAdvance", { ticks: 1, values: SHOWN }));
        }
        return knobs;
    }

    private readonly frame = (now: number): void => {
        if (!this.running) {
            return;
        }
        requestAnimationFrame(this.frame);
        if (this.lastFrame > 0) {
            this.count(now);
        }
        if (this.lastFrame > 0 && !this.waiting) {
            void this.advance();
        }
        this.lastFrame = now;
    };

    private async advance(): Promise<void> {
        const ticks = Math.floor(this.owed);
        this.owed -= ticks;
        this.waiting = true;
        try {
            this.take(await this.client.ask("playAdvance", { ticks, values: SHOWN }));
        } catch (error) {
            this.pause();
            this.failed(error as Error);
        }
        this.waiting = false;
    }

    private count(now: number): void {
        const passedMs = now - this.lastFrame;
        const most = BLOCK_MAX_S / this.periodS;
        this.owed = Math.min(this.owed + passedMs / 1000 / this.periodS / this.slowness, most);
        const { pace, window } = this;
        pace.dropped += Math.max(0, Math.round(passedMs / FRAME_MS) - 1);
        window.frames++;
        if (now - window.from >= WINDOW_MS) {
            const seconds = (now - window.from) / 1000;
            const time = this.block?.time_s ?? 0;
            pace.ratio = (time - window.time_s) / seconds;
            pace.frames = window.frames / seconds;
            this.window = { from: now, time_s: time, frames: 0 };
        }
    }

    private take(block: PlayBlock): void {
        this.block = block;
        this.track.take(block);
        this.track.drawn.tell();
    }
}
