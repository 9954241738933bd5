// SPDX-License-Identifier: MIT
// The drive measures its motor: the name plate, what the motor will see, how far it is, what was found.
import type { SchemaKey } from "../core/protocol.ts";
import { significant } from "../parts/format.ts";
import { useRefresh } from "../parts/use_refresh.ts";
import type { Board } from "./board.ts";
import { MeasuredMotor } from "./measured_motor.tsx";
import type { Measuring } from "./measuring.ts";
import { PlateForm } from "./plate_form.tsx";

const DIGITS = 3; // of a current

interface StageProps {
    board: Board;
    measuring: Measuring;
    schema: SchemaKey[];
}

function amperes(value: number): string {
    return `${significant(value, DIGITS)} A`;
}

// A person has to agree before the motor moves.
function Consent({ measuring }: StageProps) {
    const { plate } = measuring;
    if (plate === undefined) {
        return null;
    }
    const { demands, max_current_a: most } = plate;
    return (
        <section class="controls" aria-label="Before it begins">
            <h2>{`What ${plate.name} will see`}</h2>
            <ul>
                <li>
                    {`While the shaft stands: up to ${amperes(demands.largest_current_a)}, at three angles. `}
                    {`While it turns: up to ${amperes(demands.current_a)}.`}
                </li>
                <li>{`The shaft turns at up to ${Math.round(demands.speed_rpm)} rpm.`}</li>
                <li>{`Currents are peaks of a phase. The drive never asks for more than ${amperes(most)}.`}</li>
                <li>It takes 15 to 30 s of the board. Stop, or Escape, ends it at once.</li>
            </ul>
            <p class="alarm">
                <strong>The shaft must turn freely: no load that brakes or drives it, and nothing that it can catch.</strong>
            </p>
            <p class="note">The name plate becomes the configuration in force. Nothing is stored.</p>
            <div class="buttons" role="group" aria-label="Consent">
                <button type="button" class="main" onClick={() => void measuring.begin()}>Begin the measurement</button>
                <button type="button" onClick={() => measuring.again()}>Back</button>
            </div>
        </section>
    );
}

function Running({ board, measuring }: StageProps) {
    useRefresh();
    const { progress } = measuring;
    const phases = progress?.phases ?? [];
    return (
        <section class="controls" aria-label="Measurement">
            <h2>{`The drive measures, ${Math.floor(progress?.seconds ?? 0)} s`}</h2>
            <ol class="phases" aria-live="polite" aria-label="What it does">
                {phases.map((phase, index) => (
                    <li key={phase} aria-current={index === phases.length - 1 ? "step" : undefined}>{phase}</li>
                ))}
            </ol>
            <button type="button" class="main" onClick={() => void board.talk.stop()}>Stop the measurement</button>
        </section>
    );
}

function Refused({ measuring }: StageProps) {
    return (
        <section class="controls" aria-label="Measurement">
            <h2>The motor is not measured</h2>
            <p class="problem" role="alert">{measuring.problem}</p>
            <p class="note">
                If the name plate is in force, it has typical values for the rest: do not run the motor with them. Defaults, at
                Parameters, takes the configuration of the image back.
            </p>
            <button type="button" onClick={() => measuring.again()}>Back to the name plate</button>
        </section>
    );
}

function stageOf({ stage, measured }: Measuring) {
    switch (stage) {
        case "plate":
            return PlateForm;
        case "consent":
            return Consent;
        case "running":
            return Running;
        case "done":
            return measured === undefined ? Refused : MeasuredMotor;
    }
}

export function MeasureMotor({ board, schema }: { board: Board; schema: SchemaKey[] }) {
    const { measuring } = board;
    const Stage = stageOf(measuring);
    return (
        <aside class="parameters measure" aria-label="Measure the motor">
            <div class="scroll" tabIndex={0} role="group" aria-label="The measurement">
                <Stage board={board} measuring={measuring} schema={schema} />
            </div>
        </aside>
    );
}
