// SPDX-License-Identifier: MIT
// What a connection is made with.
import { useId, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { BoardFiles, Names } from "../core/protocol.ts";
import { OwnMotorChoice } from "./own_motor_choice.tsx";
import { ownMotors } from "./own_motors.ts";
import { type NumberName, NUMBERS, type Settings } from "./settings.ts";

interface Props {
    client: Client;
    names: Names;
    settings: Settings;
    setSettings(settings: Settings): void;
}

const FILES: (keyof BoardFiles)[] = ["motor", "board", "tuning"];

function namesOf(kind: keyof BoardFiles, names: Names): string[] {
    const own = kind === "motor" ? Object.keys(ownMotors()) : [];
    return [...new Set([...names[kind], ...own])];
}

function Field({ name, settings, setSettings }: Pick<Props, "settings" | "setSettings"> & { name: NumberName }) {
    const id = useId();
    const { label, unit, least, most, empty } = NUMBERS[name];
    const set = (text: string): void => setSettings({ ...settings, numbers: { ...settings.numbers, [name]: text } });
    return (
        <div class="knob">
            <label for={id}>{unit === "" ? label : `${label} [${unit}]`}</label>
            <input
                id={id} type="number" min={least} max={most} step="any" placeholder={empty} value={settings.numbers[name]}
                onInput={(event) => set(event.currentTarget.value)}
            />
        </div>
    );
}

function FileChoice({ kind, names, settings, setSettings }: Props & { kind: keyof BoardFiles }) {
    const id = useId();
    const set = (name: string): void => setSettings({ ...settings, files: { ...settings.files, [kind]: name } });
    return (
        <div class="knob">
            <label for={id}>{`${kind} file`}</label>
            <select id={id} value={settings.files[kind]} onChange={(event) => set(event.currentTarget.value)}>
                <option value="">as the board says</option>
                {namesOf(kind, names).map((name) => <option key={name}>{name}</option>)}
            </select>
        </div>
    );
}

export function PortSetup(props: Props) {
    const [, show] = useState(0);
    return (
        <div class="setup">
            <Field {...props} name="baud" />
            <Field {...props} name="keep_s" />
            <details class="setup">
                <summary>Files of the board</summary>
                {FILES.map((kind) => <FileChoice {...props} key={kind} kind={kind} />)}
                <OwnMotorChoice client={props.client} changed={() => show((count) => count + 1)} />
            </details>
            <Field {...props} name="pace" />
            <p class="note">Leave this at 1 unless the board is emulated.</p>
        </div>
    );
}
