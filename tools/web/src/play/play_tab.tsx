// SPDX-License-Identifier: MIT
// Play: the machine of the chosen scenario without its script, in real time.
import { useEffect, useState } from "preact/hooks";
import type { PlayHead } from "../core/protocol.ts";
import { FaultCard } from "../parts/fault_card.tsx";
import { Readings, readingsOf } from "../parts/readings.tsx";
import { scopeChoice, ScopeScene, type SceneProps, SpanChoice } from "../parts/scope_scene.tsx";
import { StateMachine } from "../parts/state_machine.tsx";
import type { Selection } from "../run/bench_state.ts";
import { MachineChoice } from "../run/machine_choice.tsx";
import { keepInLink, selectionOfLink } from "../run/selection_link.ts";
import type { TabProps } from "../tab.ts";
import { Controls } from "./controls.tsx";
import { MotorDrawing } from "./motor_drawing.tsx";
import type { Player } from "./player.ts";
import { READINGS } from "./shown.ts";
import { type Play, usePlay } from "./use_play.ts";

const FIRST_PANELS = [
    ["speed_command_rpm", "speed_rpm", "speed_estimated_rpm"],
    ["i_q_a", "i_d_a"],
];
const FIRST_SPAN_S = 5;
const SLOWNESS: Record<string, number> = { "1": 1, "1/10": 10, "1/100": 100, "1/1000": 1000 };

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
            <SpanChoice span={span} setSpan={setSpan} />
            <button type="button" aria-pressed={choosing} onClick={() => setChoosing(!choosing)}>Signals</button>
            <Pace play={play} />
        </div>
    );
}

interface Props {
    head: PlayHead;
    player: Player;
    play: Play;
    scope: Pick<SceneProps, "panels" | "span" | "setPanels">;
    choosing: boolean;
}

function Scene({ head, player, play, scope, choosing }: Props) {
    const { block } = play;
    return (
        <ScopeScene label="Scopes and motor" signals={head.signals} track={player.track} choosing={choosing} {...scope}>
            <MotorDrawing player={player} largestA={head.limits.current_a} />
            <StateMachine moves={head.moves} state={block?.state ?? "INIT"} />
            {block !== undefined && (
                <div class="figures">
                    <Readings caption={`Now, t = ${block.time_s.toFixed(3)} s`} rows={readingsOf(READINGS, block.values)} />
                </div>
            )}
        </ScopeScene>
    );
}

function Side({ props, play, problem, selection, choose }: {
    props: TabProps; play: Play; problem: string; selection: Selection; choose(selection: Selection): void;
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
            {problem !== "" && <p class="problem" role="alert">{problem}</p>}
            <FaultCard fault={play.block?.fault ?? null} />
            {head !== undefined && knobs !== undefined && <Controls head={head} knobs={knobs} act={play.act} />}
        </div>
    );
}

function Introduction() {
    return (
        <p class="note">
            A machine that is switched on runs here in real time: scopes, its rotor and the states of its drive. Press Start motor then,
            turn its knobs, and break its wires and sensors.
        </p>
    );
}

export function PlayTab(props: TabProps) {
    const [selection, setSelection] = useState<Selection>();
    const [linkProblem, setLinkProblem] = useState("");
    const [panels, setPanels] = useState(FIRST_PANELS);
    const [span, setSpan] = useState(FIRST_SPAN_S);
    const [choosing, setChoosing] = useState(false);
    const play = usePlay(props.client, scopeChoice(panels, span));
    useEffect(() => {
        void selectionOfLink().then((linked) => {
            setSelection(linked.selection);
            setLinkProblem(linked.problem);
        });
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
            <Side props={props} play={play} problem={play.problem || linkProblem} selection={selection} choose={choose} />
            <div class="run-main">
                <Toolbar
                    props={props} play={play} choosing={choosing} setChoosing={setChoosing} span={span} setSpan={setSpan}
                />
                {play.head !== undefined && play.player !== undefined ? (
                    <Scene
                        head={play.head} player={play.player} play={play} choosing={choosing} scope={{ panels, span, setPanels }}
                    />
                ) : <Introduction />}
            </div>
        </div>
    );
}
