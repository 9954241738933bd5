// SPDX-License-Identifier: MIT
// What a person tells a board, and what comes of it.
import type { LiveKey, Requests } from "../core/protocol.ts";
import type { BoardLink } from "./board_link.ts";
import { type Answer, Dialogue, type Said } from "./dialogue.ts";
import { Steering } from "./steering.ts";
import { Turns } from "./turns.ts";

export type Recording = Requests["liveRecord"]["back"];

export class Talk {
    readonly dialogue = new Dialogue();
    readonly steering = new Steering((line) => this.steer(line), () => this.changed());
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
    }

    // What waits for its turn is not done any more.
    drop(): void {
        this.turns.drop();
        this.steering.drop();
    }

    log(kind: Said["kind"], ...lines: string[]): void {
        if (lines.length > 0) {
            this.dialogue.add(kind, ...lines);
            this.changed();
        }
    }

    // A stop acts at once, and says what came of it as news.
    async execute(line: string): Promise<Answer> {
        if (line.trim() === "stop") {
            this.stop();
            return { text: "", refused: false };
        }
        const answer = await this.ask(line, () => this.log("asked", line));
        this.dialogue.answer(answer);
        this.changed();
        return answer;
    }

    stop(): void {
        this.drop();
        this.link()?.askStop();
    }

    keys(): Promise<LiveKey[]> {
        return this.inTurn("the list of keys", "liveKeys", null);
    }

    async record(): Promise<void> {
        this.recording = undefined;
        this.isRecording = true;
        this.log("asked", "record");
        try {
            this.recording = await this.inTurn("record", "liveRecord", null);
            this.log("answer", this.recording.text);
        } catch (error) {
            this.log("refusal", (error as Error).message);
        }
        this.isRecording = false;
        this.changed();
    }

    private inTurn<Name extends "liveExecute" | "liveKeys" | "liveRecord">(
        title: string, name: Name, given: Requests[Name]["given"], begun: () => void = () => undefined,
    ): Promise<Requests[Name]["back"]> {
        return this.turns.take(title, async () => {
            const link = this.link();
            if (link === undefined) {
                throw new Error("no board is connected");
            }
            begun();
            return link.ask(name, given);
        });
    }

    private async ask(line: string, begun?: () => void): Promise<Answer> {
        try {
            return await this.inTurn(line, "liveExecute", { line }, begun);
        } catch (error) {
            return { text: (error as Error).message, refused: true };
        }
    }

    // Of a knob: a refusal alone is worth a line.
    private async steer(line: string): Promise<Answer> {
        const answer = await this.ask(line);
        if (answer.refused) {
            this.log("asked", line);
            this.log("refusal", answer.text);
        }
        return answer;
    }
}
