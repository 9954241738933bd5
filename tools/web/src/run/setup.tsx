// SPDX-License-Identifier: MIT
// What is simulated: scenario and imperfections; and the buttons.
import { MachineChoice, type MachineChoiceProps } from "./machine_choice.tsx";
import type { Runner } from "./use_run.ts";

interface Props extends MachineChoiceProps {
    runner: Runner;
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

export function Setup(props: Props) {
    const { selection, runner } = props;
    return (
        <section class="setup" aria-label="What is simulated">
            <MachineChoice {...props} />
            <div class="buttons">
                <button type="button" class="main" onClick={() => void runner.start(selection)}>Simulate</button>
                <button type="button" disabled={runner.progress === undefined} onClick={runner.stop}>Stop</button>
                <Progress runner={runner} />
            </div>
            {runner.problem !== "" && <p class="problem" role="alert">{runner.problem}</p>}
        </section>
    );
}
