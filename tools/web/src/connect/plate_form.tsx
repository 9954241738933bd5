// SPDX-License-Identifier: MIT
// The name plate of a motor: typed, or of a file.
import { useId } from "preact/hooks";
import type { SchemaKey } from "../core/protocol.ts";
import { FileDrop } from "../parts/file_drop.tsx";
import { withUnit } from "../parts/format.ts";
import type { Board } from "./board.ts";
import type { Measuring } from "./measuring.ts";
import { PLATE_FIELDS, type PlateField, schemaOf } from "./plate.ts";

interface Props {
    board: Board;
    measuring: Measuring;
    schema: SchemaKey[];
}

function Field({ field, measuring, schema }: Omit<Props, "board"> & { field: PlateField }) {
    const id = useId();
    const { key, label, unit, isOptional = false } = field;
    const { meaning, allowed, default: unsaid } = schemaOf(schema, key) ?? { meaning: "", allowed: "", default: "" };
    const { fields, problem } = measuring;
    const title = `motor.${key}: ${meaning}; allowed: ${allowed}`;
    return (
        <div class="knob" title={title}>
            <label for={id}>
                {`${label}${unit === "" ? "" : ` [${unit}]`}`}
                {isOptional && <span class="unit">{`, optional: else ${withUnit(unsaid, unsaid.endsWith(unit) ? "" : unit)}`}</span>}
            </label>
            <input
                id={id} type="text" autocomplete="off" spellcheck={false} inputMode={key === "name" ? "text" : "decimal"}
                required={!isOptional} aria-invalid={problem.includes(`motor.${key} `) || problem.endsWith(`motor.${key}`)}
                value={fields[key]} onInput={(event) => measuring.type({ ...fields, [key]: event.currentTarget.value })}
            />
        </div>
    );
}

export function PlateForm({ board, measuring, schema }: Props) {
    const isFollowed = board.phase === "following";
    return (
        <form
            class="controls plate" aria-label="Name plate" noValidate
            onSubmit={(event) => {
                event.preventDefault();
                void measuring.check(schema);
            }}
        >
            <p class="note">
                The drive measures the motor from its name plate on: R, L, flux linkage, inertia, friction. Currents are peaks of a phase,
                1.414 times an rms value. The next step says what the motor will see.
            </p>
            {PLATE_FIELDS.map((field) => <Field key={field.key} field={field} measuring={measuring} schema={schema} />)}
            {measuring.problem !== "" && <p class="problem" role="alert">{measuring.problem}</p>}
            <button type="submit" class="main" disabled={!isFollowed}>Next</button>
            <FileDrop
                text="Or drop a file with a name plate here. Of a motor file its name plate is taken." label="Choose a plate file"
                isDisabled={!isFollowed} open={(file) => void measuring.take(file)}
            />
        </form>
    );
}
