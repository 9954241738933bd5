// SPDX-License-Identifier: MIT
// The board that the page is connected to, or was. It is followed whichever part of the bench is open, and also while nobody sees
// the page: without timers and frames of the screen, which such a page does not have. A board that hears nobody stops its motor.
import type { LiveBlock, LiveHead, SignalInfo } from "../core/protocol.ts";
import { Listeners } from "../parts/listeners.ts";
import { BoardLink } from "./board_link.ts";
import { ByteRate } from "./byte_rate.ts";
import { Scopes } from "./scopes.ts";
import type { Connection } from "./settings.ts";
import { Talk } from "./talk.ts";
import type { SerialPort } from "./web_serial.ts";

const PASS_S = 0.03;

// Signals that the page shows beside the scopes.
export const SHOWN = [
    "speed_command_rpm", "speed_estimated_rpm", "position_estimated_rad",
    "drive.signals.current.q", "drive.signals.current.d", "drive.signals.bus",
];

export type Phase = "away" | "connecting" | "following" | "leaving";

export class Board {
    readonly changed = new Listeners();
    readonly scopes = new Scopes();
    readonly talk = new Talk(() => this.link, () => this.changed.tell());
    phase: Phase = "away";
    problem = ""; // why there is no board any more
    parting = ""; // what a person is to know of the one that was left
    head: LiveHead | undefined;
    signals: SignalInfo[] = [];
    block: LiveBlock | undefined;
    rate = new ByteRate();
    private link: BoardLink | undefined;

    async connect(port: SerialPort, { baud, options }: Connection): Promise<void> {
        this.begin();
        try {
            this.link = await BoardLink.open(port, baud);
            this.head = await this.link.ask("liveOpen", { line: this.link.memory, options, scope: this.scopes.choice });
        } catch (error) {
            await this.end(error as Error);
            return;
        }
        this.phase = "following";
        this.changed.tell();
        await this.follow(this.link);
    }

    async disconnect(): Promise<void> {
        const { link } = this;
        if (link === undefined || this.phase !== "following") {
            return;
        }
        this.phase = "leaving";
        this.talk.drop();
        this.changed.tell();
        try {
            this.parting = await link.ask("liveClose", null);
            await this.end();
        } catch (error) {
            await this.end(error as Error);
        }
    }

    // Also while the board is asked who it is, or a command holds up the parting.
    cut(): void {
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

    private begin(): void {
        this.phase = "connecting";
        this.problem = "";
        this.parting = "";
        this.head = undefined;
        this.signals = [];
        this.block = undefined;
        this.rate = new ByteRate();
        this.talk.begin();
        this.scopes.begin();
        this.changed.tell();
    }

    private async end(error?: Error): Promise<void> {
        const { link } = this;
        this.talk.drop();
        this.problem = error === undefined ? "" : link?.problem || error.message;
        await link?.close();
        this.link = undefined;
        this.phase = "away";
        this.changed.tell();
    }

    // One pass after the other; the worker does what a person asks for in between.
    private async follow(link: BoardLink): Promise<void> {
        try {
            while (this.phase === "following") {
                const block = await link.ask("livePass", { seconds: PASS_S, values: SHOWN });
                this.take(block);
                if (block.in_step && this.signals.length === 0) {
                    await this.learn(link, block);
                }
            }
        } catch (error) {
            if (this.phase === "following") { // else whoever leaves says it
                await this.end(error as Error);
            }
        }
    }

    // A motor may run already: the knob begins where its command is.
    private async learn(link: BoardLink, { values }: LiveBlock): Promise<void> {
        this.talk.steering.begin({ mode: "speed", value: Math.round(values["speed_command_rpm"] ?? 0) });
        this.signals = (await link.ask("liveSignals", null)) ?? [];
        this.changed.tell();
    }

    private take(block: LiveBlock): void {
        this.block = block;
        this.rate.take(block.health.bytes);
        this.scopes.take(block);
        this.talk.log("news", ...block.said);
    }
}
