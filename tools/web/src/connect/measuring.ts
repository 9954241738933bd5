// SPDX-License-Identifier: MIT
// The drive measures its motor: from the name plate over the consent of a person to the motor file. It goes on whichever part of
// the page is open.
import type { GivenFile, Measured, Measuring as Progress, Plate, SchemaKey } from "../core/protocol.ts";
import { given } from "./given_file.ts";
import { keepMotor, nameOfMeasured } from "./own_motors.ts";
import { EMPTY_PLATE, fieldsOf, plateFile, type PlateFields } from "./plate.ts";
import type { Talk } from "./talk.ts";

// plate: it is typed. consent: what the motor will see is said. running, and then done: well or not.
export type Stage = "plate" | "consent" | "running" | "done";

export class Measuring {
    stage: Stage = "plate";
    fields: PlateFields = EMPTY_PLATE;
    plate: Plate | undefined; // as the program has read it
    progress: Progress | undefined;
    measured: Measured | undefined;
    problem = "";
    private file: GivenFile | undefined; // of the plate
    private isBeginning = false; // what a block says is of another one

    constructor(
        private readonly talk: Talk,
        private readonly changed: () => void,
    ) {}

    // Of what was measured.
    get fileName(): string {
        return nameOfMeasured(this.measured?.name ?? "");
    }

    type(fields: PlateFields): void {
        this.fields = fields;
        this.problem = "";
        this.changed();
    }

    // The fields have what a file says; of a motor file the name plate alone.
    async take(file: File): Promise<void> {
        await this.attempt(async () => {
            const plate = await this.talk.inTurn("the name plate", "boardPlate", await given(file));
            this.fields = fieldsOf(plate);
        });
    }

    // Nothing moves yet.
    async check(schema: SchemaKey[]): Promise<void> {
        await this.attempt(async () => {
            const file = plateFile(this.fields, schema);
            this.plate = await this.talk.inTurn("the name plate", "boardPlate", file);
            this.file = file;
            this.stage = "consent";
        });
    }

    async begin(): Promise<void> {
        const { file } = this;
        if (file === undefined || this.stage !== "consent") {
            return;
        }
        this.measured = undefined;
        this.progress = undefined;
        this.stage = "running";
        this.isBeginning = true;
        const { stops } = this.talk;
        await this.attempt(async () => {
            await this.talk.exchange("identify", "boardIdentify", { file, stops }, (text) => text);
        });
        this.isBeginning = false;
        if (this.problem !== "") {
            this.end(this.problem);
        }
    }

    again(): void {
        this.stage = "plate";
        this.problem = "";
        this.changed();
    }

    // With each block of the board.
    follow(progress: Progress | null): void {
        if (this.stage !== "running" || this.isBeginning || progress === null) {
            return;
        }
        const isNews = progress.phases.length !== this.progress?.phases.length;
        const ends = progress.ended && this.progress?.ended !== true;
        this.progress = progress;
        if (ends) {
            void this.finish();
        } else if (isNews) {
            this.changed();
        }
    }

    // The board has gone.
    lose(): void {
        if (this.stage === "running") {
            this.end("the connection ended before the measurement did; the board may go on with it, and ends it within 2 minutes");
        } else if (this.stage === "consent") {
            this.again();
        }
    }

    // The motor file is there for `adopt`, also for the boards that come.
    private async finish(): Promise<void> {
        try {
            const measured = await this.talk.inTurn("the measurement", "boardMeasured", null);
            this.measured = measured;
            const file = { name: `${this.fileName}.toml`, bytes: new TextEncoder().encode(measured.file) };
            await this.talk.inTurn("the motor file", "boardKeep", { name: this.fileName, file });
            keepMotor(this.fileName, measured.file);
            this.end("");
        } catch (error) {
            this.end((error as Error).message);
        }
    }

    private end(problem: string): void {
        this.stage = "done";
        this.problem = problem;
        this.changed();
    }

    private async attempt(act: () => Promise<void>): Promise<void> {
        this.problem = "";
        try {
            await act();
        } catch (error) {
            this.problem = (error as Error).message;
        }
        this.changed();
    }
}
