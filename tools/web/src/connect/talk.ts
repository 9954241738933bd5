// SPDX-License-Identifier: MIT
// What a person tells a board, and what comes of it.
import type { LiveKey, RequestName, Requests, Said } from "../core/protocol.ts";
import { Listeners } from "../parts/listeners.ts";
import type { BoardLink } from "./board_link.ts";
import { Dialogue, type Line } from "./dialogue.ts";
import { Steering } from "./steering.ts";
import { Stopping } from "./stopping.ts";
import { Turns } from "./turns.ts";

export type Recording = Requests["liveRecord"]["back"];

const CONFIGURING = ["set", "adopt", "defaults", "load", "identify"];

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
        this.tellConfigured(line, answer.refused);
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
        return this.inTurn("the list of keys", "liveKeys", null);
    }

    async record(): Promise<void> {
        this.recording = undefined;
        this.isRecording = true;
        const recorded = this.exchange("record", "liveRecord", null, ({ text }) => text);
        this.recording = await recorded.catch(() => undefined);
        this.isRecording = false;
        this.changed();
    }

    // What is no line of its own stands in the dialogue like one: `line`, and the text that is made of its answer.
    async exchange<Name extends RequestName>(
        line: string, name: Name, given: Requests[Name]["given"], textOf: (back: Requests[Name]["back"]) => string,
    ): Promise<Requests[Name]["back"]> {
        this.log("asked", line);
        try {
            const back = await this.inTurn(line, name, given);
            this.log("answer", textOf(back));
            this.tellConfigured(line, false);
            return back;
        } catch (error) {
            this.log("refusal", (error as Error).message);
            throw error;
        }
    }

    // Not where it waits for its turn when a stop comes.
    inTurn<Name extends RequestName>(title: string, name: Name, given: Requests[Name]["given"]): Promise<Requests[Name]["back"]> {
        return this.turns.take(title, async () => this.there().ask(name, given));
    }

    // As of now, for what is not to be done after a later one.
    get stops(): number {
        return this.link()?.stops ?? 0;
    }

    private there(): BoardLink {
        const link = this.link();
        if (link === undefined) {
            throw new Error("no board is connected");
        }
        return link;
    }

    private tellConfigured(line: string, isRefused: boolean): void {
        if (!isRefused && CONFIGURING.includes(line.trim().split(/\s+/)[0] ?? "")) {
            this.configured.tell();
        }
    }

    // In the dialogue a line and its answer stand together.
    private ask(line: string, isLogged: boolean): Promise<Said> {
        const { stops } = this;
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
