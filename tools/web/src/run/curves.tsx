// SPDX-License-Identifier: MIT
// The panels of a run and the tree of signals that go into them.
import { useEffect, useMemo, useState } from "preact/hooks";
import type { Run } from "../core/protocol.ts";
import type { Band } from "../parts/bands.ts";
import { type Curve, PlotPanel, type Range } from "../parts/plot_panel.tsx";
import { SignalTree } from "../parts/signal_tree.tsx";

// What can be drawn over time, of a run or of a recording.
export type Drawn = Pick<Run, "times" | "columns" | "signals" | "states" | "faults">;

interface Props {
    run: Drawn;
    before?: Drawn | undefined; // drawn faintly behind
    panels: string[][];
    onPanels(panels: string[][]): void;
}

function bandsOf(run: Drawn, end: number): Band[] {
    const states = run.states.map((state, index): Band => ({
        from: state.from_s,
        to: run.states[index + 1]?.from_s ?? end,
        label: state.name,
        kind: "state",
    }));
    const faults = run.faults.map((fault): Band => ({
        from: fault.time_s,
        to: fault.time_s,
        label: fault.name,
        kind: "fault",
    }));
    return [...states, ...faults];
}

function curvesOf(run: Drawn, names: string[]): Curve[] {
    return names.flatMap((name) => {
        const values = run.columns[name];
        const unit = run.signals.find((signal) => signal.name === name)?.unit ?? "";
        return values === undefined ? [] : [{ name, unit, values }];
    });
}

// At these times, as far as they go.
function valuesAt(times: Float64Array, { times: own }: Drawn, values: Curve["values"]): (number | null)[] {
    let at = 0;
    return Array.from(times, (time) => {
        while (at + 1 < own.length && (own[at + 1] ?? 0) <= time) {
            at++;
        }
        return time >= (own[0] ?? 0) && time <= (own.at(-1) ?? 0) ? (values[at] ?? null) : null;
    });
}

function curvesBefore(run: Drawn, before: Drawn | undefined, names: string[]): Curve[] {
    const curves = before === undefined ? [] : curvesOf(before, names);
    return curves.map((curve) => ({ ...curve, values: valuesAt(run.times, before as Drawn, curve.values), isBefore: true }));
}

interface PanelProps {
    index: number;
    props: Props;
    selected: boolean;
    select(): void;
    range: Range;
    whole: Range;
    onRange(range: Range): void;
}

function Panel({ index, props, selected, select, range, whole, onRange }: PanelProps) {
    const { run, before, panels, onPanels } = props;
    const names = panels[index] ?? [];
    const curves = useMemo(
        () => [...curvesOf(run, names), ...curvesBefore(run, before, names)],
        [run, before, names.join()],
    );
    const bands = useMemo(() => bandsOf(run, whole.to), [run]);
    const title = `Panel ${index + 1}`;
    return (
        <section class={selected ? "panel selected" : "panel"} aria-label={title} onFocusIn={select} onPointerDown={select}>
            <header>
                <button type="button" aria-pressed={selected} onClick={select}>{title}</button>
                <button
                    type="button"
                    aria-label={`Remove panel ${index + 1}`}
                    disabled={panels.length === 1}
                    onClick={() => onPanels(panels.filter((_, other) => other !== index))}
                >
                    ✕
                </button>
            </header>
            {names.length === 0 && <p class="note">Choose its signals in the list.</p>}
            <PlotPanel
                title={title} times={run.times} curves={curves} bands={bands} range={range} whole={whole}
                onRange={onRange} syncKey="run"
            />
        </section>
    );
}

function toggled(panels: string[][], index: number, name: string): string[][] {
    return panels.map((names, other) => {
        if (other !== index) {
            return names;
        }
        return names.includes(name) ? names.filter((known) => known !== name) : [...names, name];
    });
}

export function Curves(props: Props) {
    const { run, panels, onPanels } = props;
    const whole = useMemo(() => ({ from: run.times[0] ?? 0, to: run.times.at(-1) ?? 1 }), [run.times]);
    const [range, setRange] = useState<Range>(whole);
    const [chosen, setChosen] = useState(0);
    const [comparing, setComparing] = useState(true);
    const drawn = comparing ? props : { ...props, before: undefined };
    const selected = Math.min(chosen, panels.length - 1);
    useEffect(() => setRange(whole), [whole.from, whole.to]);
    return (
        <div class="curves">
            <div class="panels scroll" tabIndex={0} role="group" aria-label="Panels">
                {panels.map((_, index) => (
                    <Panel
                        key={index} index={index} props={drawn} selected={index === selected}
                        select={() => setChosen(index)} range={range} whole={whole} onRange={setRange}
                    />
                ))}
            </div>
            <aside aria-label="Choice of signals">
                <div class="buttons">
                    <button type="button" onClick={() => onPanels([...panels, []])}>Add panel</button>
                    <button type="button" onClick={() => setRange(whole)}>Show all</button>
                    {props.before !== undefined && (
                        <button type="button" aria-pressed={comparing} onClick={() => setComparing(!comparing)}>Curves before</button>
                    )}
                </div>
                {drawn.before !== undefined && <p class="note">The fainter curves are of the run before.</p>}
                <p class="note">{`A ticked signal is in panel ${selected + 1}.`}</p>
                <SignalTree
                    signals={run.signals}
                    chosen={new Set(panels[selected])}
                    onToggle={(name) => onPanels(toggled(panels, selected, name))}
                />
            </aside>
        </div>
    );
}
