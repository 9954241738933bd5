// SPDX-License-Identifier: MIT
// What is run: scenario and imperfections; and the buttons.
import { useId } from "preact/hooks";
import type { Names } from "../core/protocol.ts";
import type { Selection } from "./bench_state.ts";
import type { Runner } from "./use_run.ts";

interface Props {
    names: Names;
    selection: Selection;
    runner: Runner;
    onSelect(selection: Selection): void;
}

function Progress({ runner }: { runner: Runner }) {
    const share = runner.progress ?? 0;
    return runner.progress === undefined ? null : (
        <div class="progress">
            <progress max={1} value={share} aria-label="Progress of the run" />
            <span>{`${Math.round(share * 100)} %`}</span>
        </div>
    );
}

function Imperfections({ names, selection, onSelect }: Props) {
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

export function Setup(props: Props) {
    const { names, selection, runner, onSelect } = props;
    const id = useId();
    return (
        <section class="setup" aria-label="What is run">
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
            <div class="buttons">
                <button type="button" class="main" onClick={() => void runner.start(selection)}>Run</button>
                <button type="button" disabled={runner.progress === undefined} onClick={runner.stop}>Stop</button>
                <Progress runner={runner} />
            </div>
            {runner.problem !== "" && <p class="problem" role="alert">{runner.problem}</p>}
        </section>
    );
}
