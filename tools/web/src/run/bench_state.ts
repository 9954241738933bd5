// SPDX-License-Identifier: MIT
// What a person has chosen and edited, and what of it the simulator is given. A link holds all of it.
import { folderOf, type Choice, type FileKind, type Parts } from "../core/protocol.ts";

export interface Selection {
    scenario: string;
    with: string[];
    edits: Record<string, string>; // texts by "motors/motor_a.toml"; those that are changed
    panels: string[][]; // the signals of each
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

// The chosen one, then those that it is based on.
function scenariosOf(selection: Selection, parts: Parts): BenchFile[] {
    return [selection.scenario, ...parts.bases].map((name) => fileOf("scenario", name));
}

export function filesOf(selection: Selection, parts: Parts): BenchFile[] {
    const own = (["motor", "board", "tuning"] as const).flatMap((kind) => {
        const name = named(parts[kind]);
        return name === undefined ? [] : [fileOf(kind, name)];
    });
    return [
        ...scenariosOf(selection, parts),
        ...own,
        ...selection.with.map((name) => fileOf("imperfection", name)),
    ];
}

// A shipped file by its name, an edited one by its path.
function reference(file: BenchFile, edits: Selection["edits"]): string {
    return file.path in edits ? file.path : file.name;
}

const BASE_LINE = /^(\s*base\s*=\s*)"([^"]*)"/m;

// A scenario with a line that names its base: an edited base by its path, or the shipped one would be read.
function withBaseNamed(text: string, base: BenchFile, isEdited: boolean): string {
    const fileName = `${base.name}.toml`;
    return text.replace(BASE_LINE, (line, key: string, named: string) =>
        named === base.name || named === fileName ? `${key}"${isEdited ? fileName : base.name}"` : line);
}

// The choice with another text of one file; `shipped` has the texts of all its files by path.
export function withText(
    selection: Selection, parts: Parts, shipped: Record<string, string>, path: string, text: string,
): Selection {
    const edits = { ...selection.edits };
    const put = (at: string, now: string): void => {
        edits[at] = now;
        if (now === shipped[at]) {
            delete edits[at];
        }
    };
    put(path, text);
    const scenarios = scenariosOf(selection, parts);
    // From the last base on: what names an edited file is edited.
    for (const [base, user] of scenarios.slice(1).map((file, index) => [file, scenarios[index] as BenchFile] as const).reverse()) {
        const before = edits[user.path] ?? shipped[user.path] ?? "";
        put(user.path, withBaseNamed(before, base, base.path in edits));
    }
    return { ...selection, edits };
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
