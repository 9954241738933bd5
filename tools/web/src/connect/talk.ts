// SPDX-License-Identifier: MIT
// What a person tells a board, and what comes of it.
import type { LiveKey, Requests, Said } from "../core/protocol.ts";
import { Listeners } from "../parts/listeners.ts";
import type { BoardLink } from "./board_link.ts";
import { Dialogue, type Line } from "./dialogue.ts";
import { Steering } from "./steering.ts";
import { Stopping } from "./stopping.ts";
import { Turns } from "./turns.ts";

export type Recording = Requests["liveRecord"]["back"];

const CONFIGURING = ["set", "adopt", "defaults"];

export class Talk {
    readonly dialogue = new Dialogue();
    readonly steering = new Steering((line) => this.steer(line), () => this.changed());
    readonly stopping = new Stopping();
    readonly configured = new Listeners(); // called when the board may have other values of its keys
    recording: Recording | undefined;
    isRecording = false;
    private readonly turns = new Turns();

    constructor(
        private readonly link: () => BoardLink | undefined,
        private readonly changed: () => void,
    ) {}

    // With another board.
    begin(): void {
        this.recording = undefined;
        this.stopping.begin();
        this.steering.begin();
    }

    // What waits for its turn is not done any more.
    drop(reason: string): void {
        this.turns.drop(reason);
        this.steering.drop();
    }

    // The board hears and says no more.
    end(): void {
        this.drop("the connection has ended");
        this.stopping.lose("the connection ended before the board answered");
    }

    log(kind: Line["kind"], ...lines: string[]): void {
        if (lines.length > 0) {
            this.dialogue.add(kind, ...lines);
            this.changed();
        }
    }

    // A stop acts at once; its answer comes with a block.
    async execute(line: string): Promise<Said> {
        if (line.trim() === "stop") {
            void this.stop();
            return { text: "", refused: false };
        }
        const answer = await this.ask(line, true);
        if (!answer.refused && CONFIGURING.includes(line.trim().split(/\s+/)[0] ?? "")) {
            this.configured.tell();
        }
        return answer;
    }

    // Whether the board confirms it.
    async stop(): Promise<boolean> {
        const link = this.link();
        if (link === undefined) {
            return false;
        }
        this.drop("a stop came before its turn");
        const isConfirmed = this.stopping.ask();
        link.askStop();
        this.changed();
        return isConfirmed;
    }

    takeStop(answer: Said): void {
        this.stopping.take(answer);
        this.dialogue.add("asked", "stop");
        this.dialogue.answer(answer);
        this.changed();
    }

    keys(): Promise<LiveKey[]> {
        return this.inTurn("the list of keys", "liveKeys");
    }

    async record(): Promise<void> {
        this.recording = undefined;
        this.isRecording = true;
        this.log("asked", "record");
        try {
            this.recording = await this.inTurn("record", "liveRecord");
            this.log("answer", this.recording.text);
        } catch (error) {
            this.log("refusal", (error as Error).message);
        }
        this.isRecording = false;
        this.changed();
    }

    private there(): BoardLink {
        const link = this.link();
        if (link === undefined) {
            throw new Error("no board is connected");
        }
        return link;
    }

    private inTurn<Name extends "liveKeys" | "liveRecord">(title: string, name: Name): Promise<Requests[Name]["back"]> {
        return this.turns.take(title, async () => this.there().ask(name, null));
    }

    // In the dialogue a line and its answer stand together.
    private ask(line: string, isLogged: boolean): Promise<Said> {
        const stops = this.link()?.stops ?? 0;
        const heard = (answer: Said): Said => {
            if (isLogged) {
                this.dialogue.answer(answer);
                this.changed();
            }
            return answer;
        };
        const failed = (error: Error): Said => heard({ text: error.message, refused: true });
        const act = async (): Promise<Said> => {
            const link = this.there();
            if (isLogged) {
                this.log("asked", line);
            }
            return link.ask("liveExecute", { line, stops }).then(heard, failed);
        };
        return this.turns.take(line, act).catch(failed);
    }

    // Of a knob: a refusal alone is worth a line.
    private async steer(line: string): Promise<Said> {
        const answer = await this.ask(line, false);
        if (answer.refused) {
            this.log("asked", line);
            this.log("refusal", answer.text);
        }
        return answer;
    }
}
