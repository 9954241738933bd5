// SPDX-License-Identifier: MIT
// Rolling scopes below each other, and the tree of signals that go into them.
import type { ComponentChildren } from "preact";
import { useMemo, useState } from "preact/hooks";
import type { ScopeChoice, SignalInfo } from "../core/protocol.ts";
import { RollingScope, type ScopePicture } from "./rolling_scope.tsx";
import type { ScopeTrack } from "./scope_track.ts";
import { SignalTree } from "./signal_tree.tsx";

const SPANS_S = [1, 2, 5, 10];

interface PanelProps {
    index: number;
    names: string[];
    signals: SignalInfo[];
    track: ScopeTrack;
    span: number;
    selected: boolean;
    select(): void;
}

function ScopePanel({ index, names, signals, track, span, selected, select }: PanelProps) {
    const curves = useMemo(
        () => names.map((name) => ({ name, unit: signals.find((signal) => signal.name === name)?.unit ?? "" })),
        [names.join(), signals],
    );
    const attach = useMemo(() => (draw: (picture: ScopePicture) => void) => {
        const update = (): void => draw(track.picture(names));
        update();
        return track.drawn.add(update);
    }, [track, names.join()]);
    const title = `Scope ${index + 1}`;
    return (
        <section class={selected ? "panel selected" : "panel"} aria-label={title} onPointerDown={select}>
            <header><button type="button" aria-pressed={selected} onClick={select}>{title}</button></header>
            <RollingScope title={title} curves={curves} span={span} attach={attach} />
        </section>
    );
}

function toggled(panels: string[][], index: number, name: string): string[][] {
    const without = (names: string[]): string[] => names.filter((known) => known !== name);
    return panels.map((names, at) => (at !== index ? names : names.includes(name) ? without(names) : [...names, name]));
}

export function SpanChoice({ span, setSpan }: { span: number; setSpan(span: number): void }) {
    return (
        <label>
            {"Scope "}
            <select value={span} onChange={(event) => setSpan(Number(event.currentTarget.value))}>
                {SPANS_S.map((seconds) => <option key={seconds} value={seconds}>{`${seconds} s`}</option>)}
            </select>
        </label>
    );
}

export interface SceneProps {
    label: string;
    signals: SignalInfo[];
    track: ScopeTrack;
    panels: string[][];
    span: number;
    choosing: boolean; // of signals
    beside?: ComponentChildren;
    children: ComponentChildren; // beside the scopes where there is room, else below them
    setPanels(panels: string[][]): void;
}

export function ScopeScene({ label, signals, track, panels, span, choosing, beside, children, setPanels }: SceneProps) {
    const [chosen, setChosen] = useState(0);
    return (
        <div class="scene">
            <div class="scene-main scroll" tabIndex={0} role="group" aria-label={label}>
                <div class="scene-parts">
                    <div class="panels">
                        {panels.map((names, index) => (
                            <ScopePanel
                                key={index} index={index} names={names} signals={signals} track={track} span={span}
                                selected={index === chosen} select={() => setChosen(index)}
                            />
                        ))}
                    </div>
                    <div class="scene-beside">{children}</div>
                </div>
            </div>
            {choosing && (
                <aside aria-label="Choice of signals">
                    <p class="note">{`A ticked signal is in scope ${chosen + 1}.`}</p>
                    <SignalTree
                        signals={signals} chosen={new Set(panels[chosen])}
                        onToggle={(name) => setPanels(toggled(panels, chosen, name))}
                    />
                </aside>
            )}
            {beside}
        </div>
    );
}

export function scopeChoice(panels: string[][], span: number): ScopeChoice {
    return { signals: [...new Set(panels.flat())], span_s: span };
}
