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

// Name: what is given, and what comes back.
export interface Requests {
    load: { given: null; back: { names: Names; schema: SchemaKey[] } };
    readFile: { given: { path: string }; back: string };
    writeFiles: { given: { files: Record<string, string> }; back: null };
    parts: { given: Choice; back: Parts };
    check: { given: { kind: FileKind; file: string; text: string; choice: Choice | null }; back: Problem[] };
    run: { given: { choice: Choice; signals: string[] }; back: Run };
    trace: { given: { choice: Choice }; back: string }; // what `motorsim run --trace` writes
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

export type Answer =
    | { id: number; value: unknown }
    | { id: number; error: string; cancelled: boolean }
    | { id: number; progress: number }; // share that is done
