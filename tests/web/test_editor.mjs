// SPDX-License-Identifier: MIT
// The editor of the tab Simulate: errors at the line in the program's words, completion, help, and a link that holds the edits.
import assert from "node:assert/strict";
import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { motorsim, openFile, replaceLine, ROOT, settled, until, withPage } from "./bench.mjs";

const MOTOR = "motors/motor_a.toml";
const KEY = "resistance_ohm";

async function openMotor(page) {
    await settled(page);
    return openFile(page, MOTOR, KEY);
}

// What the native program says of the same files.
async function nativeError(wrong) {
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    await mkdir(join(folder, "motors"));
    const text = await readFile(join(ROOT, "host_sim", MOTOR), "utf8");
    await writeFile(join(folder, MOTOR), text.replace(new RegExp(`^${KEY}.*$`, "m"), wrong));
    const { stderr } = await motorsim(["run", "s1_robust", "--set", `motor=${MOTOR}`], folder);
    await rm(folder, { recursive: true });
    return stderr.trim().replace(/^motorsim: /, "");
}

for (const [what, wrong] of [["a value out of its range", `${KEY} = -3`], ["a misspelt key", "resistence_ohm = 1"],
    ["no TOML", `${KEY} = `], ["a value that the drive cannot have", `${KEY} = 49`]]) {
    test(`${what} is marked at its line, in the program's words`, async () => withPage(async (page) => {
        const line = await openMotor(page);
        await replaceLine(page, line, wrong);
        const marked = page.locator(".cm-line").filter({ hasText: wrong.trim() });
        const said = await nativeError(wrong);
        // The list of errors stays open and is renewed; a half-typed line may have another error.
        await page.keyboard.press("Control+Shift+M");
        await page.locator(".cm-panel-lint .cm-diagnosticText").getByText(said, { exact: true }).waitFor();
        await page.locator(".cm-lint-marker-error").waitFor();
        const number = Number(/^motors\/motor_a\.toml:(\d+):/.exec(said)?.[1]);
        const index = await marked.evaluate((element) => [...element.parentElement.children].indexOf(element) + 1);
        assert.equal(index, number);
    }));
}

test("keys are completed and explained", async () => withPage(async (page) => {
    const line = await openMotor(page);
    await line.getByText(KEY).hover();
    await page.locator(".key-help").getByText("phase resistance").waitFor();
    await page.locator(".key-help").getByText("0.001 to 50 Ω; default: required").waitFor();
    await line.click();
    await page.keyboard.press("End");
    await page.keyboard.press("Enter");
    await page.keyboard.type("thermal");
    // By the pointer: a list that has just opened takes no key for a moment, lest someone who types takes its first entry.
    await page.locator(".cm-tooltip-autocomplete").getByText("thermal_time_constant_s").click();
    await page.locator(".cm-line").filter({ hasText: "thermal_time_constant_s = " }).waitFor();
}));

test("an edited file is run, and a link holds it", async () => withPage(async (page) => {
    const line = await openMotor(page);
    await replaceLine(page, line, `${KEY} = 5`);
    await page.getByText("The choice has changed since this run: press Simulate.").waitFor();
    await page.getByRole("button", { name: "Simulate" }).click();
    const command = page.getByText(`motorsim run s1_robust --set motor=${MOTOR}`, { exact: true });
    await command.waitFor();
    const row = page.getByRole("row", { name: /^resistance_ohm/ });
    await row.getByText("5", { exact: true }).first().waitFor();
    const link = page.url();
    await page.goto("about:blank");
    await page.goto(link);
    await settled(page);
    await command.waitFor();
    await row.getByText("5", { exact: true }).first().waitFor();
}));

test("an edited base is run in place of the shipped one", async () => withPage(async (page) => {
    await settled(page);
    const command = page.locator("code");
    await command.getByText("motorsim run s1_robust", { exact: true }).waitFor();
    const line = await openFile(page, "scenarios/s1.toml", "duration_s = ");
    const ticks = async () => Number(/^\d+/.exec(await page.getByText(/^\d+ ticks in/).innerText())[0]);
    const before = await ticks();
    await replaceLine(page, line, "duration_s = 3.0");
    await command.getByText("motorsim run scenarios/s1_robust.toml", { exact: true }).waitFor();
    await page.getByRole("button", { name: "Simulate" }).click();
    await until(ticks, (after) => after > before);
    await page.getByRole("button", { name: "scenarios/s1_robust.toml" }).click();
    await page.locator(".cm-line").getByText('base = "s1.toml"').waitFor();
    await page.getByRole("button", { name: "scenarios/s1.toml" }).click();
    await page.getByRole("button", { name: "Undo all changes" }).click();
    await command.getByText("motorsim run s1_robust", { exact: true }).waitFor();
}));
