// SPDX-License-Identifier: MIT
// The page has what the native program prints and writes, byte for byte.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { ask, motorsim, ROOT, withPage } from "./bench.mjs";

const SCENARIOS = readdirSync(join(ROOT, "host_sim/scenarios")).map((name) => name.replace(/\.toml$/, "")).sort();
const WITH = { ideal: [], all: ["all"] };
const CHOICES = SCENARIOS.flatMap((scenario) =>
    Object.entries(WITH).map(([name, sets]) => [`${scenario}, ${name}`, { scenario, with: sets, set: [] }]));

function argumentsOf({ scenario, with: sets, set }) {
    return ["run", scenario, ...sets.flatMap((name) => ["--with", name]), ...set.flatMap((text) => ["--set", text])];
}

async function compareResults(page, choice) {
    const { value, error } = await ask(page, "run", { choice, signals: [] }, { keep: ["text", "json"] });
    assert.equal(error, undefined);
    const table = await motorsim(argumentsOf(choice));
    const json = await motorsim([...argumentsOf(choice), "--json", "-"]);
    assert.deepEqual(value, { text: table.stdout, json: json.stdout });
}

async function compareTrace(page, choice) {
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    const path = join(folder, "trace.csv");
    await motorsim([...argumentsOf(choice), "--trace", path]);
    const { value } = await ask(page, "trace", { choice });
    assert.ok(value === readFileSync(path, "utf8"), "the traces differ");
    await rm(folder, { recursive: true });
}

async function compareError(page, choice) {
    const { error } = await ask(page, "run", { choice, signals: [] });
    const { stderr, status } = await motorsim(argumentsOf(choice));
    assert.equal(status, 2);
    assert.equal(`motorsim: ${error}\n`, stderr);
}

test("the same results", async (t) => withPage(async (page) => {
    for (const [name, choice] of CHOICES) {
        await t.test(name, () => compareResults(page, choice));
    }
}));

test("the same trace", async (t) => withPage(async (page) => {
    for (const [name, choice] of CHOICES.filter(([name]) => /^s[12]_robust,/.test(name))) {
        await t.test(name, () => compareTrace(page, choice));
    }
}));

test("the same error", async (t) => withPage(async (page) => {
    const wrong = { scenario: ["nothing"], imperfection: ["s1", ["nothing"]], value: ["s1", [], ["motor.resistance_ohm=-1"]] };
    for (const [name, [scenario, sets = [], set = []]] of Object.entries(wrong)) {
        await t.test(name, () => compareError(page, { scenario, with: sets, set }));
    }
}));

test("what is stopped says so", async (t) => withPage(async (page) => {
    // So long that nobody is too late.
    const choice = { scenario: "s1_robust", with: [], set: ["scenario.duration_s=300"] };
    for (const [name, given] of Object.entries({ run: { choice, signals: [] }, trace: { choice } })) {
        await t.test(name, async () => {
            assert.deepEqual(await ask(page, name, given, { cancel: true }), { id: 1, error: "stopped", cancelled: true });
        });
    }
}));
