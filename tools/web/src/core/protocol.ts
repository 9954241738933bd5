// SPDX-License-Identifier: MIT
// What the page and the worker say to each other. A request has a number; its answers carry it. `Requests` is the one list
// of what can be asked: a part of the bench adds its rows here and its handlers in worker.ts.

export interface Problem {
    line: number; // of the file that was asked about; 0: of none
    text: string; // the program's line
}

export interface SchemaKey {
    section: string;
    key: string;
    allowed: string;
    default: string;
    meaning: string;
    kinds: FileKind[];
}

export const FILE_KINDS = ["scenario", "imperfection", "motor", "board", "tuning"] as const;
export type FileKind = (typeof FILE_KINDS)[number];

// Of the data folder and of the user's work folder.
export function folderOf(kind: FileKind): string {
    return `${kind}s`;
}

export interface Names extends Record<FileKind, string[]> {
    titles: Record<string, string>; // of the scenarios
}

// As of the command line: names or paths, and overrides.
export interface Choice {
    scenario: string;
    with: string[];
    set: string[];
}

// What a scenario is made of.
export interface Parts {
    motor: string;
    board: string;
    tuning: string;
    bases: string[]; // the scenarios that it is based on, the nearest first
}

export interface ResultRow {
    name: string;
    value: string;
    limit: string;
    holds: boolean;
}

export interface Fault {
    time_s: number;
    name: string;
    measure: string;
    advice: string;
}

export interface StateChange {
    from_s: number;
    name: string;
}

export interface Parameter {
    name: string;
    configured: number;
    estimated: number;
    actual: number;
}

export interface SignalInfo {
    name: string;
    unit: string;
    format: string;
}

export interface RunHead {
    ticks: number;
    period_s: number;
    title: string;
    motor: string;
    board: string;
    tuning: string;
}

export interface RunResult {
    rows: ResultRow[];
    accepted: boolean;
    notes: string[];
    faults: Fault[];
    states: StateChange[];
    parameters: Parameter[];
    text: string; // what `motorsim run` prints
    json: string; // what `motorsim run --json` writes
}

export interface Run extends RunResult {
    head: RunHead;
    times: Float64Array;
    columns: Record<string, Float32Array>;
    signals: SignalInfo[];
}

export type PlayMode = "speed" | "position" | "torque";

// How the knobs of what is played with stand.
export interface Knobs {
    mode: PlayMode;
    command: number; // rpm, degrees, or N·m
    load_nm: number;
    broken: string[]; // what lasts
}

export interface PlayHead {
    period_s: number;
    motor: string;
    board: string;
    tuning: string;
    bus_v: number;
    has_sensor: boolean; // of the angle
    limits: { speed_rpm: number; position_deg: number; torque_nm: number; load_nm: number; current_a: number };
    knobs: Knobs;
    moves: { from: string; to: string }[]; // of the state machine
    signals: SignalInfo[];
}

// What a person does to it. Break and repair have the words and values of [[scenario.fault]].
export type PlayAct =
    | { call: "request"; what: "run" | "stop" | "clear" }
    | { call: "command"; mode: PlayMode; value: number }
    | { call: "load"; value: number }
    | { call: "break" | "repair"; what: string; value: number | null };

export interface ScopeChoice {
    signals: string[];
    span_s: number; // on the screen
}

// After some ticks: how things stand, and the points of the scope that have become whole.
export interface PlayBlock {
    tick: number;
    time_s: number;
    state: string;
    fault: Fault | null;
    values: Record<string, number | null>; // of the signals that were asked for; null: not known
    times: Float64Array;
    columns: Record<string, Float32Array>;
}

export type StepSource = "scenario" | "play" | "recording";

export interface StepHead {
    name: string;
    recorded: boolean;
}

// A signal at a tick. A word of the firmware has the last four, of which `recorded` is a recording's.
export interface SignalValue {
    name: string;
    value: number | null;
    unit: string;
    word?: string; // RUN; empty for a number
    raw?: string;
    format?: string;
    recorded?: string;
}

export interface DiffRow {
    module: string;
    quantity: string;
    unit: string;
    drive: number;
    reference: number;
    tolerance: number;
    departs: boolean;
}

export interface StepView {
    tick: number;
    first: number;
    last: number;
    time_s: number;
    position: string; // the stepper's line, and what is watched
    state: string;
    fault: { name: string; advice: string; tick: number } | null;
    stages: { title: string; rows: SignalValue[] }[];
    diff: DiffRow[];
    edits: string[];
    breaks: string[];
}

export interface ReplayHead {
    summary: string; // as `motorsim replay` prints it
    equal: boolean; // the firmware does what was recorded
    step_tick: number; // of the fault, or of what departs
    faults: Fault[];
    signals: SignalInfo[];
}

export interface Curves {
    times: Float64Array;
    columns: Record<string, Float32Array>;
    states: StateChange[];
}

// Files of a board's configuration, as of `motorsim live`; empty: the shipped file that the board's name says.
export interface BoardFiles {
    motor: string;
    board: string;
    tuning: string;
}

export interface LiveOptions {
    files: BoardFiles;
    pace: number; // seconds of the board in a second
    keep_s: number; // for a recording
}

// That a person has chosen or dropped.
export interface GivenFile {
    name: string;
    bytes: Uint8Array;
}

// What a measurement asks of a motor.
export interface Demands {
    current_a: number; // peak of a phase, while the shaft turns
    largest_current_a: number; // the same while it stands
    speed_rpm: number;
}

// What a name plate says.
export interface Plate {
    name: string;
    pole_pairs: number;
    max_speed_rpm: number;
    continuous_current_a: number;
    max_current_a: number;
    thermal_time_constant_s: number;
    demands: Demands;
}

// A measurement that is under way, or has just ended.
export interface Measuring {
    seconds: number; // of the board, since it began
    phases: string[]; // in the board's words; the last one is what it does now
    ended: boolean;
}

export interface Measured {
    name: string;
    rows: { title: string; value: string; bar: string; unit: string }[];
    remarks: string[];
    file: string; // the text of the motor file
}

// Who answers.
export interface LiveHead {
    name: string;
    build: string; // of the firmware: the beginning of its commit or hash, hexadecimal
    ticks_per_s: number;
    baud: number; // as the board says; 0: its line has no rate
    baud_needed: number; // for all ticks
    speed_max_rpm: number;
    torque_max_nm: number; // of the largest current
    moves: { from: string; to: string }[]; // of the state machine
}

// After some time of the board: how it stands, and the points of the scope that have become whole.
export interface LiveBlock extends PlayBlock {
    in_step: boolean; // else state, fault, values and time are the last ones that are known; the state is "" before the first
    command: BoardCommand | null; // in force; null: not known
    stop: Said | null; // what the board has answered to a stop since the last block
    timeout_s: number | null; // without a PC the drive stops after so long; 0: it never does; null: not known
    measuring: Measuring | null;
    said: string[]; // lines since the last block
    health: LiveHealth;
}

export interface BoardCommand {
    run: boolean;
    mode: PlayMode;
    value: number; // rpm, or degrees of the shaft
}

export interface Said {
    text: string;
    refused: boolean;
}

export interface LiveHealth {
    load_pct: number; // of the board's processor
    late_ticks: number; // control ticks that came late
    tick_lost: boolean; // the control tick stays away
    gaps: number;
    departures: number; // how often the board's state was not that of the same inputs here
    hashes: number; // compared
    broken: number; // frames that came damaged
    bytes: number; // that came in
    no_stream: string; // why the board sends no ticks; empty: it does
    reset: string; // why the board's chip has started
    source: string; // who commands the drive: nobody, console, link, input
    input_lost: string; // why the board's input is lost; empty: it is there, or there is none
}

// A key of the board's motor, board or tuning file, with the value that the files and what was set make.
export interface LiveKey {
    name: string; // section.key
    value: string;
    allowed: string;
    meaning: string;
}

// Name: what is given, and what comes back.
export interface Requests {
    load: { given: null; back: { names: Names; schema: SchemaKey[] } };
    readFile: { given: { path: string }; back: string };
    writeFiles: { given: { files: Record<string, string> }; back: null };
    parts: { given: Choice; back: Parts };
    check: { given: { kind: FileKind; file: string; text: string; choice: Choice | null }; back: Problem[] };
    run: { given: { choice: Choice; signals: string[] }; back: Run };
    trace: { given: { choice: Choice }; back: string }; // what `motorsim run --trace` writes
    playStart: { given: { choice: Choice; scope: ScopeChoice }; back: PlayHead };
    playHead: { given: null; back: PlayHead | null };
    playScope: { given: ScopeChoice; back: null };
    playAdvance: { given: { ticks: number; values: string[] }; back: PlayBlock };
    playAct: { given: PlayAct; back: Knobs };
    stepOpen: { given: { source: StepSource; choice: Choice | null }; back: StepHead };
    stepExecute: { given: { line: string }; back: Said };
    stepComplete: { given: { before: string; word: string }; back: string[] };
    stepLook: { given: null; back: StepView };
    replayOpen: { given: GivenFile; back: ReplayHead };
    replayHead: { given: null; back: ReplayHead | null };
    // `motors`: texts of files by their names, as of boardKeep
    liveOpen: {
        given: { line: SharedArrayBuffer; motors: Record<string, string>; options: LiveOptions; scope: ScopeChoice };
        back: LiveHead;
    };
    liveHead: { given: null; back: LiveHead };
    liveSignals: { given: null; back: SignalInfo[] | null }; // null: not in step yet
    liveScope: { given: ScopeChoice; back: null };
    livePass: { given: { seconds: number; values: string[] }; back: LiveBlock };
    liveExecute: { given: { line: string; stops: number }; back: Said }; // `stops` asked for when it was: it is not done after a later one
    liveKeys: { given: null; back: LiveKey[] };
    liveRecord: { given: null; back: { text: string; log: string } }; // what was said, and the recording as a log
    liveClose: { given: null; back: string }; // what a person is to know of the board that is left, or nothing
    boardPlate: { given: GivenFile; back: Plate };
    boardIdentify: { given: { file: GivenFile; stops: number }; back: string }; // of a name plate; `stops` as of liveExecute
    boardMeasured: { given: null; back: Measured };
    boardKeep: { given: { name: string; file: GivenFile }; back: null }; // a motor file, as if it was shipped under this name
    boardDump: { given: null; back: { text: string; bytes: Uint8Array<ArrayBuffer> } }; // the block in force
    boardLoad: { given: GivenFile; back: string };
    replayColumns: { given: { signals: string[] }; back: Curves };
}

export type RequestName = keyof Requests;

export interface Request<Name extends RequestName = RequestName> {
    id: number;
    name: Name;
    given: Requests[Name]["given"];
}

export interface Cancel {
    cancel: number; // the id of a request
}

// To the board, while a request is under way.
export interface ToLine {
    line: Uint8Array;
}

export type Answer =
    | { id: number; value: unknown }
    | { id: number; error: string; cancelled: boolean }
    | { id: number; progress: number }; // share that is done; of stepExecute the tick
