// SPDX-License-Identifier: MIT
// Play: the machine of the chosen scenario without its script, in real time.
import { useEffect, useMemo, useState } from "preact/hooks";
import type { PlayBlock, PlayHead, ScopeChoice } from "../core/protocol.ts";
import { shown } from "../parts/format.ts";
import { RollingScope, type ScopePicture } from "../parts/rolling_scope.tsx";
import { SignalTree } from "../parts/signal_tree.tsx";
import { FIRST, type Selection } from "../run/bench_state.ts";
import { MachineChoice } from "../run/machine_choice.tsx";
import { keepInLink, selectionOfLink } from "../run/selection_link.ts";
import type { TabProps } from "../tabs.ts";
import { Controls } from "./controls.tsx";
import { MotorDrawing } from "./motor_drawing.tsx";
import type { Player } from "./player.ts";
import { StateMachine } from "./state_machine.tsx";
import { type Play, usePlay } from "./use_play.ts";

const FIRST_PANELS = [
    ["speed_command_rpm", "speed_rpm", "speed_estimated_rpm"],
    ["i_q_a", "i_d_a"],
];
const FIRST_SPAN_S = 5;
const SPANS_S = [1, 2, 5, 10];
const SLOWNESS: Record<string, number> = { "1": 1, "1/10": 10, "1/100": 100, "1/1000": 1000 };
const SCOPE_PX = 126;

const READINGS: [string, string, string][] = [
    ["Speed", "speed_rpm", "rpm"],
    ["Speed, estimated", "speed_estimated_rpm", "rpm"],
    ["Torque", "torque_nm", "N·m"],
    ["i_q", "i_q_a", "A"],
    ["i_d", "i_d_a", "A"],
    ["v_q", "v_q_v", "V"],
    ["v_d", "v_d_v", "V"],
    ["Bus", "bus_v", "V"],
    ["Rotor position", "position_rad", "rad"],
];

function Readings({ block }: { block: PlayBlock }) {
    return (
        <table class="readings">
            <caption>{`Now, t = ${block.time_s.toFixed(3)} s`}</caption>
            <tbody>
                {READINGS.map(([label, name, unit]) => (
                    <tr key={name}>
                        <th scope="row">{label}</th>
                        <td>{`${shown(block.values[name])} ${unit}`}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

function FaultCard({ block }: { block: PlayBlock | undefined }) {
    const fault = block?.fault ?? null;
    return (
        <div role="alert">
            {fault !== null && (
                <div class="fault">
                    <strong>{`${fault.name} at ${shown(fault.time_s)} s`}</strong>
                    <p>{fault.measure}</p>
                    <p>{fault.advice}</p>
                    <p class="note">Repair what is broken, press Clear fault, then Run.</p>
                </div>
            )}
        </div>
    );
}

interface ScopeProps {
    index: number;
    names: string[];
    head: PlayHead;
    player: Player;
    span: number;
    selected: boolean;
    select(): void;
}

function ScopePanel({ index, names, head, player, span, selected, select }: ScopeProps) {
    const curves = useMemo(
        () => names.map((name) => ({ name, unit: head.signals.find((signal) => signal.name === name)?.unit ?? "" })),
        [names.join(), head],
    );
    const attach = useMemo(() => (draw: (picture: ScopePicture) => void) => {
        const update = (): void => draw({ data: player.data(names), now: player.block?.time_s ?? 0, bands: player.bands });
        update();
        return player.onDraw(update);
    }, [player, names.join()]);
    const title = `Scope ${index + 1}`;
    return (
        <section class={selected ? "panel selected" : "panel"} aria-label={title} onPointerDown={select}>
            <header><button type="button" aria-pressed={selected} onClick={select}>{title}</button></header>
            <RollingScope title={title} curves={curves} span={span} height={SCOPE_PX} attach={attach} />
        </section>
    );
}

function Pace({ play }: { play: Play }) {
    const { ratio, frames, dropped } = play.pace;
    return (
        <span class="pace">
            {play.running ? `${ratio.toFixed(2)} × real time, ${frames.toFixed(0)} frames/s, ${dropped} dropped` : "paused"}
        </span>
    );
}

interface ToolbarProps {
    props: TabProps;
    play: Play;
    choosing: boolean;
    setChoosing(choosing: boolean): void;
    span: number;
    setSpan(span: number): void;
}

function Toolbar({ props, play, choosing, setChoosing, span, setSpan }: ToolbarProps) {
    const { player } = play;
    return (
        <div class="buttons toolbar">
            <button type="button" disabled={player === undefined} onClick={() => play.setRunning(!play.running)}>
                {play.running ? "Pause" : "Go on"}
            </button>
            <button type="button" disabled={player === undefined} onClick={() => props.show("step", "play")}>Step through this</button>
            <label>
                {"Time × "}
                <select onChange={(event) => player && (player.slowness = SLOWNESS[event.currentTarget.value] ?? 1)}>
                    {Object.keys(SLOWNESS).map((name) => <option key={name}>{name}</option>)}
                </select>
            </label>
            <label>
                {"Scope "}
                <select value={span} onChange={(event) => setSpan(Number(event.currentTarget.value))}>
                    {SPANS_S.map((seconds) => <option key={seconds} value={seconds}>{`${seconds} s`}</option>)}
                </select>
            </label>
            <button type="button" aria-pressed={choosing} onClick={() => setChoosing(!choosing)}>Signals</button>
            <Pace play={play} />
        </div>
    );
}

function toggled(panels: string[][], index: number, name: string): string[][] {
    const without = (names: string[]): string[] => names.filter((known) => known !== name);
    return panels.map((names, at) => (at !== index ? names : names.includes(name) ? without(names) : [...names, name]));
}

interface SceneProps {
    head: PlayHead;
    player: Player;
    play: Play;
    scope: Scope;
    choosing: boolean;
}

interface Scope {
    panels: string[][];
    span: number;
    setPanels(panels: string[][]): void;
}

function Scene({ head, player, play, scope, choosing }: SceneProps) {
    const [chosen, setChosen] = useState(0);
    const { panels, span, setPanels } = scope;
    return (
        <div class="scene">
            <div class="scene-main scroll" tabIndex={0} role="group" aria-label="Scopes and motor">
                {panels.map((names, index) => (
                    <ScopePanel
                        key={index} index={index} names={names} head={head} player={player} span={span}
                        selected={index === chosen} select={() => setChosen(index)}
                    />
                ))}
                <div class="scene-below">
                    <MotorDrawing player={player} largestA={head.limits.current_a} />
                    <StateMachine moves={head.moves} state={play.block?.state ?? "INIT"} />
                    {play.block !== undefined && <Readings block={play.block} />}
                </div>
            </div>
            {choosing && (
                <aside aria-label="Choice of signals">
                    <p class="note">{`A ticked signal is in scope ${chosen + 1}.`}</p>
                    <SignalTree
                        signals={head.signals} chosen={new Set(panels[chosen])}
                        onToggle={(name) => setPanels(toggled(panels, chosen, name))}
                    />
                </aside>
            )}
        </div>
    );
}

function scopeChoice(panels: string[][], span: number): ScopeChoice {
    return { signals: [...new Set(panels.flat())], span_s: span };
}

function Side({ props, play, selection, choose }: {
    props: TabProps; play: Play; selection: Selection; choose(selection: Selection): void;
}) {
    const { head, knobs } = play;
    return (
        <div class="side scroll" tabIndex={0} role="group" aria-label="The machine">
            <details class="setup" open={head === undefined}>
                <summary>{head === undefined ? "Machine" : `${head.motor}, ${head.board}, ${head.tuning}`}</summary>
                <MachineChoice names={props.names} selection={selection} onSelect={choose} />
            </details>
            <button type="button" class={head === undefined ? "main" : ""} onClick={() => void play.begin(selection)}>
                {head === undefined ? "Switch the machine on" : "Begin anew"}
            </button>
            {play.problem !== "" && <p class="problem" role="alert">{play.problem}</p>}
            <FaultCard block={play.block} />
            {head !== undefined && knobs !== undefined && <Controls head={head} knobs={knobs} act={play.act} />}
        </div>
    );
}

export function PlayTab(props: TabProps) {
    const [selection, setSelection] = useState<Selection>();
    const [panels, setPanels] = useState(FIRST_PANELS);
    const [span, setSpan] = useState(FIRST_SPAN_S);
    const [choosing, setChoosing] = useState(false);
    const play = usePlay(props.client, scopeChoice(panels, span));
    useEffect(() => {
        selectionOfLink().then(setSelection, () => setSelection(FIRST)); // Run has said that a link is damaged
    }, []);
    useEffect(() => play.setScope(scopeChoice(panels, span)), [panels, span]);
    if (selection === undefined) {
        return null;
    }
    const choose = (next: Selection): void => {
        setSelection(next);
        keepInLink(next);
        void play.begin(next);
    };
    return (
        <div class="run">
            <Side props={props} play={play} selection={selection} choose={choose} />
            <div class="run-main">
                <Toolbar
                    props={props} play={play} choosing={choosing} setChoosing={setChoosing} span={span} setSpan={setSpan}
                />
                {play.head !== undefined && play.player !== undefined && (
                    <Scene
                        head={play.head} player={play.player} play={play} choosing={choosing} scope={{ panels, span, setPanels }}
                    />
                )}
            </div>
        </div>
    );
}
