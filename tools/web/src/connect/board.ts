// SPDX-License-Identifier: MIT
// The board that the page is connected to, or was. It is followed whichever part of the bench is open, and also while nobody sees
// the page: without timers and frames of the screen, which such a page does not have. Where tuning.command_timeout_s says so, a
// board that hears nobody for that long stops its motor.
import type { LiveBlock, LiveHead, LiveOptions, SignalInfo } from "../core/protocol.ts";
import { Listeners } from "../parts/listeners.ts";
import { BoardLink } from "./board_link.ts";
import { ByteRate } from "./byte_rate.ts";
import { Measuring } from "./measuring.ts";
import { ownMotors } from "./own_motors.ts";
import { Scopes } from "./scopes.ts";
import { rotorDeg, SHOWN } from "./shown.ts";
import { Talk } from "./talk.ts";
import { alertAfterwards } from "./time_out.ts";
import type { SerialPort } from "./web_serial.ts";

const PASS_S = 0.03;
const FRESH_MS = 500; // at the board's own pace

export type Phase = "away" | "connecting" | "following" | "leaving" | "closing";

function isSilence(error: Error): boolean {
    return error.message.startsWith("the board does not answer");
}

function silenceAt(rates: number[]): Error {
    return new Error(
        `no board answers at ${rates.join(", ")} baud; check its power, its port, and that the rate of its image (board.baud) is tried`,
    );
}

export class Board {
    readonly changed = new Listeners();
    readonly scopes = new Scopes();
    readonly talk = new Talk(() => this.link, () => this.changed.tell());
    readonly measuring = new Measuring(this.talk, () => this.changed.tell());
    phase: Phase = "away";
    problem = ""; // why there is no board any more
    parting = ""; // what a person is to know of the one that was left
    danger = ""; // of the motor of one that was lost
    baud = 0; // of the line: the rate that is tried, then the one at which the board answers
    head: LiveHead | undefined;
    signals: SignalInfo[] = [];
    block: LiveBlock | undefined;
    timeoutS: number | null = null; // as of LiveBlock, when it was known last
    rate = new ByteRate();
    private link: BoardLink | undefined;
    private isCut = false; // by a person
    private pace = 1;
    private newestMs = 0; // when the newest tick came

    constructor() {
        this.talk.configured.add(() => void this.learnHead());
    }

    // What is known of the board is how it stands now.
    get isNow(): boolean {
        const isFresh = performance.now() - this.newestMs < FRESH_MS / this.pace;
        return this.phase === "following" && this.block?.in_step === true && isFresh;
    }

    get mayRun(): boolean {
        return this.block?.command?.run ?? true;
    }

    // At the first of the rates at which there is an answer.
    async connect(port: SerialPort, rates: number[], options: LiveOptions): Promise<void> {
        this.begin(options.pace);
        try {
            const link = await this.find(port, rates, options);
            this.phase = "following";
            this.changed.tell();
            await this.follow(link);
        } catch (error) {
            await this.lose(error as Error);
        }
    }

    async disconnect(): Promise<void> {
        const { link } = this;
        if (link === undefined || this.phase !== "following") {
            return;
        }
        this.phase = "leaving";
        this.talk.drop("the board was left before its turn");
        this.changed.tell();
        try {
            this.parting = await link.ask("liveClose", null);
            await this.end();
        } catch (error) {
            await this.lose(error as Error);
        }
    }

    // One that does not confirm the stop is not left.
    async stopAndDisconnect(): Promise<void> {
        if (await this.talk.stop()) {
            await this.disconnect();
        }
    }

    // Also while the port opens, the board is asked who it is, or a command holds up the parting.
    cut(): void {
        this.isCut = true;
        this.link?.cut();
    }

    async setScope(panels: string[][], span: number): Promise<void> {
        this.scopes.panels = panels;
        this.scopes.span = span;
        this.changed.tell();
        if (this.phase === "following") {
            const { choice } = this.scopes;
            await this.link?.ask("liveScope", choice).catch((error: Error) => this.talk.log("refusal", error.message));
            this.scopes.track.setScope(choice);
        }
    }

    private begin(pace: number): void {
        this.phase = "connecting";
        this.problem = "";
        this.parting = "";
        this.danger = "";
        this.head = undefined;
        this.signals = [];
        this.block = undefined;
        this.timeoutS = null;
        this.rate = new ByteRate();
        this.isCut = false;
        this.pace = pace;
        this.talk.begin();
        this.scopes.begin();
        this.changed.tell();
    }

    private async find(port: SerialPort, rates: number[], options: LiveOptions): Promise<BoardLink> {
        for (const baud of rates) {
            this.baud = baud;
            this.changed.tell();
            const link = await BoardLink.open(port, baud);
            this.link = link;
            if (await this.answers(link, options)) {
                return link;
            }
            this.link = undefined;
            await link.close();
        }
        throw silenceAt(rates);
    }

    // Any other answer than a board's is an error.
    private async answers(link: BoardLink, options: LiveOptions): Promise<boolean> {
        try {
            if (this.isCut) {
                throw new Error("it is not wanted any more");
            }
            this.head = await link.ask("liveOpen", {
                line: link.memory, motors: ownMotors(), options, scope: this.scopes.choice,
            });
            return true;
        } catch (error) {
            if (!isSilence(error as Error)) {
                throw error;
            }
            return false;
        }
    }

    // Another configuration has another name and other limits.
    private async learnHead(): Promise<void> {
        try {
            this.head = await this.talk.inTurn("who the board is", "liveHead", null);
            this.changed.tell();
        } catch {
            // it has gone, or a stop came first: the one before stays
        }
    }

    // Not as it was to end.
    private async lose(error: Error): Promise<void> {
        if (!this.isCut) {
            this.problem = this.link?.problem || error.message;
        }
        if (this.head !== undefined && this.mayRun) {
            this.danger = alertAfterwards(this.timeoutS);
        }
        await this.end();
    }

    private async end(): Promise<void> {
        const { link } = this;
        this.phase = "closing";
        this.link = undefined;
        this.talk.end();
        this.measuring.lose();
        this.changed.tell();
        try {
            await link?.close();
        } catch (error) {
            this.problem = [this.problem, (error as Error).message].filter((text) => text !== "").join(" ");
        }
        this.phase = "away";
        this.changed.tell();
    }

    // One pass after the other; the worker does what a person asks for in between. Rejects when the board is lost.
    private async follow(link: BoardLink): Promise<void> {
        while (this.phase === "following") {
            this.take(await link.ask("livePass", { seconds: PASS_S, values: SHOWN }));
            if (this.block?.in_step === true && this.signals.length === 0) {
                this.signals = (await link.ask("liveSignals", null)) ?? [];
                this.changed.tell();
            }
        }
    }

    private take(block: LiveBlock): void {
        if (block.time_s !== this.block?.time_s) {
            this.newestMs = performance.now();
        }
        this.block = block;
        this.timeoutS = block.timeout_s ?? this.timeoutS;
        this.rate.take(block.health.bytes);
        this.scopes.take(block);
        this.talk.log("news", ...block.said);
        if (block.stop !== null) {
            this.talk.takeStop(block.stop);
        }
        this.measuring.follow(block.measuring);
        this.talk.steering.follow(block.command, rotorDeg(block));
    }
}
