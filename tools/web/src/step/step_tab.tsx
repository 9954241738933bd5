// SPDX-License-Identifier: MIT
// Step: any tick, forwards and backwards, by the engine of `motorsim debug`.
import { useId, useState } from "preact/hooks";
import type { StepSource, StepView } from "../core/protocol.ts";
import type { TabProps } from "../tab.ts";
import { Console } from "./console.tsx";
import { Diff, Stages } from "./tables.tsx";
import { type Stepper, useStep } from "./use_step.ts";

const SOURCES: Record<StepSource, string> = { scenario: "The scenario", play: "What was played", recording: "Recording" };
const FAR = 100; // ticks

function isSource(text: string): text is StepSource {
    return text in SOURCES;
}

function Source({ stepper }: { stepper: Stepper }) {
    return (
        <label>
            {"Step through "}
            <select
                value={stepper.source}
                onChange={(event) => isSource(event.currentTarget.value) && void stepper.open(event.currentTarget.value)}
            >
                {Object.entries(SOURCES).map(([id, title]) => <option key={id} value={id}>{title}</option>)}
            </select>
        </label>
    );
}

// What is played has no end.
function reach(source: StepSource, { first, last }: StepView): string {
    return source === "play" ? `kept from tick ${first} on` : `ticks ${first} to ${last}`;
}

function Walk({ stepper, view }: { stepper: Stepper; view: StepView }) {
    const walks: [string, string, string][] = [
        ["|◀", "First tick", `goto ${view.first}`],
        ["◀◀", `Back ${FAR} ticks`, `back ${FAR}`],
        ["◀ Back", "Back one tick", "back"],
        ["Step ▶", "Step one tick", "step"],
        ["▶▶", `Step ${FAR} ticks`, `step ${FAR}`],
    ];
    return (
        <div class="buttons" role="group" aria-label="Walk">
            {walks.map(([text, label, line]) => (
                <button type="button" key={line} aria-label={label} title={label} onClick={() => void stepper.walk(line)}>{text}</button>
            ))}
        </div>
    );
}

// A field whose text makes a command.
function Ask({ label, button, hint, onEnter }: { label: string; button: string; hint: string; onEnter(text: string): void }) {
    const id = useId();
    const [text, setText] = useState("");
    return (
        <form
            class="buttons"
            onSubmit={(event) => {
                event.preventDefault();
                onEnter(text.trim());
            }}
        >
            <label for={id}>{label}</label>
            <input
                id={id} type="text" placeholder={hint} autocomplete="off" spellcheck={false} value={text}
                onInput={(event) => setText(event.currentTarget.value)}
            />
            <button type="submit">{button}</button>
        </form>
    );
}

function Running({ stepper }: { stepper: Stepper }) {
    return stepper.runningAt === undefined ? null : (
        <div class="buttons">
            <span role="status">{`runs, at tick ${stepper.runningAt}`}</span>
            <button type="button" onClick={stepper.stop}>Stop</button>
        </div>
    );
}

function Change({ stepper }: { stepper: Stepper }) {
    const [word, setWord] = useState("set");
    return (
        <div class="buttons" role="group" aria-label="Change">
            <select aria-label="How" value={word} onChange={(event) => setWord(event.currentTarget.value)}>
                {["set", "force", "release"].map((name) => <option key={name}>{name}</option>)}
            </select>
            <Ask
                label={word === "release" ? "Signal" : "Signal = value"} button="Apply"
                hint={word === "release" ? "in.adc_ia" : "speed_command_rpm = 500"}
                onEnter={(text) => void stepper.execute(`${word} ${text}`)}
            />
        </div>
    );
}

function Place({ stepper, view }: { stepper: Stepper; view: StepView }) {
    const { fault } = view;
    return (
        <div role="status" class="place">
            <pre>{view.position.trimEnd()}</pre>
            {fault !== null && (
                <div class="fault">
                    <strong>{`${fault.name} at tick ${fault.tick}`}</strong>
                    <p>{fault.advice}</p>
                    <button
                        type="button" class="small" disabled={fault.tick <= view.first}
                        onClick={() => void stepper.walk(`goto ${fault.tick - 1}`)}
                    >
                        To the tick before the fault
                    </button>
                </div>
            )}
        </div>
    );
}

function Kept({ view }: { view: StepView }) {
    const lists: [string, string[]][] = [["Changes", view.edits], ["Breaks", view.breaks.map((text) => `on ${text}`)]];
    return (
        <>
            {lists.filter(([, lines]) => lines.length > 0).map(([title, lines]) => (
                <details key={title}>
                    <summary>{`${title} (${lines.length})`}</summary>
                    <ul>{lines.map((line, index) => <li key={index}>{line}</li>)}</ul>
                </details>
            ))}
        </>
    );
}

// Arrow keys walk, unless they are typed into a field.
function onKey(event: KeyboardEvent, stepper: Stepper): void {
    const typed = event.target instanceof Element && event.target.closest("input, select, textarea") !== null;
    const word = { ArrowLeft: "back", ArrowRight: "step" }[event.key];
    if (!typed && word !== undefined && stepper.view !== undefined) {
        event.preventDefault();
        void stepper.walk(event.shiftKey ? `${word} ${FAR}` : word);
    }
}

function Tick({ stepper, view }: { stepper: Stepper; view: StepView }) {
    const [table, setTable] = useState("Stages");
    return (
        <div class="run-main">
            <div class="buttons">
                {["Stages", "Beside double precision"].map((name) => (
                    <button type="button" key={name} aria-pressed={table === name} onClick={() => setTable(name)}>{name}</button>
                ))}
                <span class="note">← → one tick, with Shift {FAR}</span>
            </div>
            <div class="scroll tick" tabIndex={0} role="group" aria-label="The present tick">
                {table === "Stages" ? <Stages view={view} recorded={stepper.head?.recorded ?? false} /> : <Diff view={view} />}
            </div>
        </div>
    );
}

export function StepTab({ client, what }: TabProps) {
    const stepper = useStep(client, isSource(what) ? what : "scenario");
    const { view, problem, head } = stepper;
    return (
        <div class="step" onKeyDown={(event) => onKey(event, stepper)}>
            <div class="step-side">
                <Source stepper={stepper} />
                {problem !== "" && <p class="problem" role="alert">{problem}</p>}
                {view !== undefined && (
                    <>
                        <p class="note">{`${head?.name}: ${reach(stepper.source, view)}`}</p>
                        <Walk stepper={stepper} view={view} />
                        <Ask label="Continue until" button="Continue" hint="state == FAULT"
                            onEnter={(text) => void stepper.execute(text === "" ? "run" : `run until ${text}`)} />
                        <Ask label="Go to" button="Go" hint="4711 or 0.35s" onEnter={(text) => void stepper.execute(`goto ${text}`)} />
                        <Change stepper={stepper} />
                        <Running stepper={stepper} />
                        <Place stepper={stepper} view={view} />
                        <Kept view={view} />
                        <Console client={client} stepper={stepper} />
                    </>
                )}
            </div>
            {view !== undefined && <Tick stepper={stepper} view={view} />}
        </div>
    );
}
