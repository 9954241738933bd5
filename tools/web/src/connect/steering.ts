// SPDX-License-Identifier: MIT
// The command that a person gives with a knob. A slider gives more of them than a line carries: the newest one counts. While
// nobody gives one, the knob shows what is in force, whoever gave that.
import type { BoardCommand, PlayMode, Said } from "../core/protocol.ts";

interface Target {
    mode: PlayMode;
    value: number; // rpm, degrees of the shaft, or N·m
}

const AT_REST: Target = { mode: "speed", value: 0 };
const REST_MS = 1000; // after a person's input
const DIGITS: Record<PlayMode, number> = { speed: 2, position: 2, torque: 4 }; // behind the point: a small motor makes mN·m
const UNITS: Record<PlayMode, string> = { speed: "", position: "deg", torque: "" };

function rounded(value: number, mode: PlayMode): number {
    return Number(value.toFixed(DIGITS[mode]));
}

function lineOf({ mode, value }: Target): string {
    return `${mode} ${rounded(value, mode)}${UNITS[mode]}`;
}

// The drive counts from the zero of the turn that it is in when position control begins.
function withinTurn(deg: number): number {
    return deg - 360 * Math.round(deg / 360);
}

export class Steering {
    private target = AT_REST; // of the knob
    private inForce = AT_REST;
    private rotorDeg: number | undefined; // where it was last
    private originDeg: number | undefined; // where it was when position was chosen
    private next: Target | undefined;
    private isGiving = false;
    private isHeld = false; // a person is in the field
    private isChosen = false; // a mode, of which nothing was sent yet
    private inputMs = -Infinity;

    constructor(
        private readonly give: (line: string) => Promise<Said>,
        private readonly changed: () => void,
    ) {}

    get mode(): PlayMode {
        return this.target.mode;
    }

    // Rpm, degrees from where the rotor was, or N·m. Undefined: that is not known yet.
    get value(): number | undefined {
        const from = this.from();
        return from === undefined ? undefined : rounded(this.target.value - from, this.mode);
    }

    // With another board.
    begin(): void {
        this.rotorDeg = undefined;
        this.inForce = AT_REST;
        this.isHeld = false;
        this.inputMs = -Infinity;
        this.drop();
    }

    // Sends nothing: the motor would turn to a position at once.
    choose(mode: PlayMode): void {
        this.isChosen = mode !== this.inForce.mode;
        this.show(this.isChosen ? { mode, value: 0 } : this.inForce);
        this.changed();
    }

    hold(isHeld: boolean): void {
        this.isHeld = isHeld;
    }

    go(value: number): void {
        const from = this.from();
        if (from === undefined) {
            return;
        }
        this.isChosen = false;
        this.inputMs = performance.now();
        this.next = { mode: this.mode, value: from + value };
        this.target = this.next;
        this.changed();
        if (!this.isGiving) {
            void this.giveAll();
        }
    }

    drop(): void {
        this.next = undefined;
        this.isChosen = false;
        this.show(this.inForce);
    }

    // As the board has it. Null: not known.
    follow(command: BoardCommand | null, rotorDeg: number | null): void {
        const before = [this.mode, this.value];
        this.rotorDeg = rotorDeg ?? this.rotorDeg;
        this.inForce = command === null ? this.inForce : { mode: command.mode, value: command.value };
        this.show(command !== null && this.isIdle() ? this.inForce : this.target);
        if (this.mode !== before[0] || this.value !== before[1]) {
            this.changed();
        }
    }

    // Only positions count from somewhere.
    private from(): number | undefined {
        return this.mode === "position" ? this.originDeg : 0;
    }

    private isIdle(): boolean {
        const isBusy = this.isGiving || this.isHeld || this.isChosen;
        return !isBusy && performance.now() - this.inputMs > REST_MS;
    }

    private show(target: Target): void {
        if (target.mode !== this.mode || target.mode !== "position") {
            this.originDeg = undefined;
        }
        this.target = target;
        if (this.mode === "position" && this.originDeg === undefined && this.rotorDeg !== undefined) {
            this.originDeg = this.isChosen ? withinTurn(this.rotorDeg) : this.rotorDeg;
            this.target = this.isChosen ? { mode: "position", value: this.originDeg } : target;
        }
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
            this.inForce = target;
        } else if (this.next === undefined) {
            this.show(this.inForce);
        }
        this.changed();
    }
}
