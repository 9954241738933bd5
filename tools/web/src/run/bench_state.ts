// SPDX-License-Identifier: MIT
// What a person has chosen and edited, and what of it the simulator is given. A link holds all of it.
import { folderOf, type Choice, type FileKind } from "../core/protocol.ts";

export interface Selection {
    scenario: string;
    with: string[];
    edits: Record<string, string>; // texts by "motors/motor_a.toml"; those that are changed
    panels: string[][]; // the signals of each
}

export interface Parts {
    motor: string;
    board: string;
    tuning: string;
}

// A file that can be edited.
export interface BenchFile {
    kind: FileKind;
    name: string; // without ending
    path: string; // in the data folder and in the work folder
}

export const DEFAULT_PANELS = [
    ["speed_command_rpm", "speed_rpm", "speed_estimated_rpm"],
    ["angle_error_el_deg"],
    ["i_q_a", "i_q_estimated_a", "i_d_a", "i_d_estimated_a"],
];

export const FIRST: Selection = { scenario: "s1_robust", with: [], edits: {}, panels: DEFAULT_PANELS };

export function fileOf(kind: FileKind, name: string): BenchFile {
    return { kind, name, path: `${folderOf(kind)}/${name}.toml` };
}

// "motors/motor_a.toml" is the file motor_a; a motor of the zoo is in no file.
function named(source: string): string | undefined {
    return /([^/]+)\.toml$/.exec(source)?.[1];
}

export function filesOf(selection: Selection, parts: Parts): BenchFile[] {
    const own = (["motor", "board", "tuning"] as const).flatMap((kind) => {
        const name = named(parts[kind]);
        return name === undefined ? [] : [fileOf(kind, name)];
    });
    return [
        fileOf("scenario", selection.scenario),
        ...own,
        ...selection.with.map((name) => fileOf("imperfection", name)),
    ];
}

// A shipped file by its name, an edited one by its path.
function reference(file: BenchFile, edits: Selection["edits"]): string {
    return file.path in edits ? file.path : file.name;
}

// Without the overrides for motor, board and tuning.
export function plainChoice({ scenario, with: sets, edits }: Selection): Choice {
    return {
        scenario: reference(fileOf("scenario", scenario), edits),
        with: sets.map((name) => reference(fileOf("imperfection", name), edits)),
        set: [],
    };
}

export function choiceOf(selection: Selection, parts: Parts): Choice {
    const edited = filesOf(selection, parts).filter(
        ({ kind, path }) => ["motor", "board", "tuning"].includes(kind) && path in selection.edits,
    );
    return { ...plainChoice(selection), set: edited.map(({ kind, path }) => `${kind}=${path}`) };
}

export function argumentsOf({ scenario, with: sets, set }: Choice): string[] {
    return ["run", scenario, ...sets.flatMap((name) => ["--with", name]), ...set.flatMap((text) => ["--set", text])];
}

// Of a link; throws for what is none.
export function selectionFrom(given: unknown): Selection {
    const { scenario, with: sets, edits, panels } = given as Partial<Selection>;
    const areTexts = (list: unknown): list is string[] =>
        Array.isArray(list) && list.every((item) => typeof item === "string");
    const good =
        typeof scenario === "string" && areTexts(sets) && Array.isArray(panels) && panels.every(areTexts) &&
        typeof edits === "object" && edits !== null && areTexts(Object.values(edits));
    if (!good) {
        throw new Error("the link holds no choice of a scenario");
    }
    return { scenario, with: sets, edits: edits as Selection["edits"], panels };
}
