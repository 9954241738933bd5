// SPDX-License-Identifier: MIT
// The program in the page prints what the native one prints, byte for byte.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { ask, motorsim, ROOT, withPage } from "./bench.mjs";

const SCENARIOS = readdirSync(join(ROOT, "host_sim/scenarios")).map((name) => name.replace(/\.toml$/, "")).sort();
const WITH = { ideal: [], all: ["--with", "all"] };

async function inPage(page, args, files = []) {
    const { value, error } = await ask(page, "program", { args, files });
    assert.equal(error, undefined);
    return value;
}

async function compare(page, args) {
    const { files, ...here } = await inPage(page, args);
    assert.deepEqual(files, {});
    assert.deepEqual(here, await motorsim(args));
}

test("the same output", async (t) => withPage(async (page) => {
    for (const scenario of SCENARIOS) {
        for (const [name, imperfections] of Object.entries(WITH)) {
            const args = ["run", scenario, ...imperfections];
            await t.test(`${scenario}, ${name}: JSON`, () => compare(page, [...args, "--json", "-"]));
        }
    }
    for (const args of [["run", "s1_robust"], ["list"], ["--help"], ["run", "--help"], ["signals", "s1"],
        ["run", "nothing"], ["run", "s1", "--set", "motor.resistance_ohm=-1"], ["identify", "s1"],
        ["estimators"], ["run", "s1", "--estimator", "kalman"]]) {
        await t.test(args.join(" "), () => compare(page, args));
    }
    await t.test("a trace", async () => {
        const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
        const args = (path) => ["run", "s1_robust", "--trace", path];
        await motorsim(args(join(folder, "trace.csv")));
        const { files } = await inPage(page, args("/tmp/trace.csv"), ["/tmp/trace.csv"]);
        assert.ok(files["/tmp/trace.csv"] === readFileSync(join(folder, "trace.csv"), "utf8"), "the traces differ");
        await rm(folder, { recursive: true });
    });
    await t.test("a run that is stopped says so", async () => {
        const choice = { scenario: "s1_robust", with: [], set: [] };
        const answer = await ask(page, "run", { choice, signals: [] }, true);
        assert.deepEqual(answer, { id: 1, error: "stopped", cancelled: true });
    });
}));
