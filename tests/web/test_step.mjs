// SPDX-License-Identifier: MIT
// The tab Step, used as a person would, beside `motorsim debug`.
import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { settled, motorsim, openTab, switchOn, withPage } from "./bench.mjs";

const SCENARIO = "s1_robust";
const TICK = 9000; // in RUN

async function stepper(page) {
    await settled(page);
    await openTab(page, "Step");
    await page.getByText("Stages of tick 0,").waitFor();
}

const commandLine = (page) => page.getByLabel(/^Command/);

async function command(page, line) {
    await commandLine(page).fill(line);
    await page.keyboard.press("Enter");
}

function atTick(page, tick) {
    return page.getByText(new RegExp(`^Stages of tick ${tick},`)).waitFor();
}

// What the stepper said last.
async function said(page) {
    return (await page.locator(".said pre").last().innerText()).trimEnd();
}

// What the native program answers to the last of these lines.
async function native(lines) {
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    const script = join(folder, "script");
    await writeFile(script, lines.map((line) => `${line}\n`).join(""));
    const { stdout } = await motorsim(["debug", SCENARIO, "--script", script]);
    await rm(folder, { recursive: true });
    return stdout.split(/^\(s1_robust \d+\) .*\n/m).at(-1).trimEnd();
}

for (const line of ["stages", "diff", "print speed_rpm drive.rotor.observer.speed", "signals observer", "hash", "step 100", "nonsense"]) {
    test(`the answer to '${line}' is the program's`, async () => withPage(async (page) => {
        await stepper(page);
        await command(page, `goto ${TICK}`);
        await atTick(page, TICK);
        await command(page, line);
        await page.locator(".said code").nth(1).waitFor();
        assert.equal(await said(page), await native([`goto ${TICK}`, line]));
    }));
}

test("the tables show what the program prints", async () => withPage(async (page) => {
    await stepper(page);
    await command(page, `goto ${TICK}`);
    await atTick(page, TICK);
    const stages = await native([`goto ${TICK}`, "stages"]);
    const rows = await page.locator(".stages tbody tr:not(.stage-title)").allInnerTexts();
    assert.ok(rows.length > 30);
    for (const [name, value, raw] of rows.map((row) => row.split("\t"))) {
        const printed = stages.split("\n").find((line) => line.trim().split(/\s+/)[0] === name);
        assert.ok(printed?.includes(raw === "" ? value : `raw ${raw} `), `${name} ${value} ${raw} beside ${printed}`);
    }
    await page.getByRole("button", { name: "Beside double precision" }).click();
    const diff = await native([`goto ${TICK}`, "diff"]);
    const count = /no departure: (\d+) values within their roundings/.exec(diff)[1];
    await page.getByText(`Tick ${TICK} beside double precision: ${count} values within their roundings`).waitFor();
}));

test("keys walk forwards and backwards, to the same words", async () => withPage(async (page) => {
    await stepper(page);
    await command(page, `goto ${TICK}`);
    await atTick(page, TICK);
    const table = page.locator(".stages");
    const here = await table.innerText();
    await page.getByRole("group", { name: "The present tick" }).focus();
    await page.keyboard.press("ArrowRight");
    await atTick(page, TICK + 1);
    assert.notEqual(await table.innerText(), here);
    await page.keyboard.press("ArrowLeft");
    await atTick(page, TICK);
    assert.equal(await table.innerText(), here);
    await page.keyboard.press("Shift+ArrowRight");
    await atTick(page, TICK + 100);
    await page.getByRole("button", { name: "Back one tick" }).click();
    await atTick(page, TICK + 99);
}));

test("it runs until an expression holds, in the same tick as the program", async () => withPage(async (page) => {
    await stepper(page);
    await page.getByLabel("Continue until").fill("speed_rpm > 900");
    await page.keyboard.press("Enter");
    const printed = await native(["run until speed_rpm > 900"]);
    const tick = /^tick (\d+) /m.exec(printed)[1];
    await atTick(page, tick);
    assert.equal(await said(page), printed);
    await page.getByLabel("Go to").fill("0.1s");
    await page.keyboard.press("Enter");
    await page.getByText(/t = 0\.1000 s/).first().waitFor();
}));

test("what is set and forced is listed and ends with release", async () => withPage(async (page) => {
    await stepper(page);
    await command(page, `goto ${TICK}`);
    await atTick(page, TICK);
    await page.getByLabel("Signal = value").fill("in.adc_ia.raw = 3000");
    await page.getByLabel("How").selectOption("force");
    await page.getByRole("button", { name: "Apply" }).click();
    await page.getByText("Changes (1)").click();
    await page.getByText(`force in.adc_ia.raw = 3000 from tick ${TICK} on`).last().waitFor();
    await page.getByRole("button", { name: "Step one tick" }).click();
    await page.getByRole("row", { name: /^in\.adc_ia / }).getByText("3000", { exact: true }).waitFor();
    await page.getByLabel("How").selectOption("release");
    await page.getByLabel("Signal", { exact: true }).fill("in.adc_ia");
    await page.getByRole("button", { name: "Apply" }).click();
    await page.getByText("Changes (1)").waitFor();
    await page.getByText(`force in.adc_ia.raw = 3000 at tick ${TICK}`, { exact: true }).last().waitFor();
}));

test("the command line recalls and completes", async () => withPage(async (page) => {
    await stepper(page);
    await command(page, "step 5");
    await atTick(page, 5);
    await command(page, "");
    await atTick(page, 10);
    await commandLine(page).focus();
    await page.keyboard.press("ArrowUp");
    assert.equal(await commandLine(page).inputValue(), "step 5");
    await commandLine(page).fill("print speed_est");
    await page.keyboard.press("Control+ ");
    await page.waitForFunction(() => document.activeElement.value === "print speed_estimated_rpm ");
    await commandLine(page).fill("print drive.rotor.obs");
    await page.keyboard.press("Control+ ");
    await page.getByText(/drive\.rotor\.observer\.\S+ {2}drive\.rotor\.observer\./).waitFor();
}));

test("a long run is shown and stopped", async () => withPage(async (page) => {
    await settled(page);
    await switchOn(page);
    await page.getByRole("button", { name: "Step through this" }).click();
    await page.getByLabel("Continue until").fill("speed_rpm > 1000000");
    await page.keyboard.press("Enter");
    await page.getByText(/^runs, at tick \d+$/).waitFor();
    await page.getByRole("button", { name: "Stop" }).click();
    await page.getByText("stopped: interrupted").waitFor();
    await page.getByRole("button", { name: "Step one tick" }).click();
}));

test("without a machine or a recording it says so", async () => withPage(async (page) => {
    await stepper(page);
    await page.getByLabel("Step through").selectOption("play");
    await page.getByText("nothing has been played yet", { exact: true }).waitFor();
    await page.getByLabel("Step through").selectOption("recording");
    await page.getByText("no recording is open", { exact: true }).waitFor();
}));
