// SPDX-License-Identifier: MIT
// Which scenario, and with which imperfections.
import { useId } from "preact/hooks";
import type { Names } from "../core/protocol.ts";
import type { Selection } from "./bench_state.ts";

export interface MachineChoiceProps {
    names: Names;
    selection: Selection;
    onSelect(selection: Selection): void;
}

function Imperfections({ names, selection, onSelect }: MachineChoiceProps) {
    const toggle = (name: string): void =>
        onSelect({
            ...selection,
            with: selection.with.includes(name)
                ? selection.with.filter((other) => other !== name)
                : [...selection.with, name],
        });
    return (
        <fieldset>
            <legend>Imperfections</legend>
            <div class="choices">
                {names.imperfection.map((name) => (
                    <label key={name}>
                        <input type="checkbox" checked={selection.with.includes(name)} onChange={() => toggle(name)} />
                        {name}
                    </label>
                ))}
            </div>
        </fieldset>
    );
}

export function MachineChoice(props: MachineChoiceProps) {
    const { names, selection, onSelect } = props;
    const id = useId();
    return (
        <>
            <label for={id}>Scenario</label>
            <select
                id={id}
                value={selection.scenario}
                onChange={(event) => onSelect({ ...selection, scenario: event.currentTarget.value })}
            >
                {names.scenario.map((name) => (
                    <option key={name} value={name}>{`${name}: ${names.titles[name] ?? ""}`}</option>
                ))}
            </select>
            <Imperfections {...props} />
        </>
    );
}
