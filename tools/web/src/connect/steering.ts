// SPDX-License-Identifier: MIT
// The command that a person gives with a knob. A slider gives more of them than a line carries: the newest one counts.
import type { PlayMode } from "../core/protocol.ts";
import type { Answer } from "./dialogue.ts";

export interface Target {
    mode: PlayMode;
    value: number; // rpm, or degrees
}

function lineOf({ mode, value }: Target): string {
    return mode === "speed" ? `speed ${value}` : `position ${value}deg`;
}

export class Steering {
    shown: Target = { mode: "speed", value: 0 };
    private accepted = this.shown;
    private next: Target | undefined;
    private isGiving = false;

    constructor(
        private readonly give: (line: string) => Promise<Answer>,
        private readonly changed: () => void,
    ) {}

    // As the board has it, or as the knob is to begin: nothing is sent.
    begin(target: Target): void {
        this.shown = target;
        this.accepted = target;
        this.changed();
    }

    go(value: number): void {
        this.next = { ...this.shown, value };
        this.shown = this.next;
        this.changed();
        if (!this.isGiving) {
            void this.giveAll();
        }
    }

    drop(): void {
        this.next = undefined;
    }

    private async giveAll(): Promise<void> {
        this.isGiving = true;
        while (this.next !== undefined) {
            const target = this.next;
            this.next = undefined;
            const { refused } = await this.give(lineOf(target));
            this.settle(target, refused);
        }
        this.isGiving = false;
    }

    // A knob shows what was refused no longer.
    private settle(target: Target, refused: boolean): void {
        if (!refused) {
            this.accepted = target;
        } else if (this.next === undefined) {
            this.shown = this.accepted;
        }
        this.changed();
    }
}
