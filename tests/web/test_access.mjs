// SPDX-License-Identifier: MIT
// axe-core finds nothing in any view, at four widths, light and dark; nothing is wider than its window; what the page weighs.
import assert from "node:assert/strict";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { violations } from "./axe.mjs";
import { button, openTab, recordedFault, setting, settled, state, switchOn, WINDOWS, withPage } from "./bench.mjs";
import { connectToReady, run, setKey, withBoard } from "./connected.mjs";
import { connectTo, outOfTheBox } from "./out_of_the_box.mjs";
import { askToMeasure, fillPlate } from "./plate.mjs";

const BYTES_MAX = 830_000; // with gzip -9, which each static server has
const beyond = (page) => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

// At each width.
async function assertFits(page, view) {
    for (const size of WINDOWS) {
        await page.setViewportSize(size);
        assert.ok((await beyond(page)) <= 0, `${view} at ${size.width}`);
    }
}

test("axe-core finds nothing at four widths, light and dark", async () => withPage(async (page) => {
    await settled(page);
    assert.deepEqual(await violations(page), []);
    await page.getByRole("button", { name: "Files" }).click();
    await page.locator(".cm-content").waitFor();
    assert.deepEqual(await violations(page), []);
    await switchOn(page);
    await page.getByRole("button", { name: "Signals", exact: true }).click();
    await page.getByRole("button", { name: "Open phase a" }).click();
    assert.deepEqual(await violations(page), []);
    await openTab(page, "Step");
    await page.getByText("Stages of tick 0,").waitFor();
    assert.deepEqual(await violations(page), []);
    await page.getByRole("button", { name: "Beside double precision" }).click();
    await page.getByLabel(/^Command/).fill("nonsense");
    await page.keyboard.press("Enter");
    await page.locator("pre.problem").waitFor();
    assert.deepEqual(await violations(page), []);
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    await openTab(page, "Replay");
    assert.deepEqual(await violations(page), []);
    await page.getByLabel("Or choose a file").setInputFiles(await recordedFault(folder));
    await page.getByRole("button", { name: /^Step from tick/ }).waitFor();
    assert.deepEqual(await violations(page), []);
    await rm(folder, { recursive: true });
    await openTab(page, "Connect");
    await page.getByRole("heading", { name: /Web Serial/ }).waitFor();
    assert.deepEqual(await violations(page), []);
}, { init: () => delete Navigator.prototype.serial }));

test("axe-core finds nothing beside a board", async () => withBoard(async (page, cable) => {
    assert.deepEqual(await violations(page), []);
    await connectToReady(page);
    await run(page);
    await button(page, "Parameters").click();
    await setKey(page, "board.temperature_max_c", "20"); // the simulated power stage has 25 °C
    await state(page, "FAULT");
    assert.deepEqual(await violations(page), []);
    await openTab(page, "Simulate");
    assert.deepEqual(await violations(page), []);
    await openTab(page, "Connect");
    await cable.pull();
    await button(page, "Connect").waitFor();
    assert.deepEqual(await violations(page), []);
}));

test("axe-core finds nothing while a motor is measured", async () => outOfTheBox(async (page) => {
    await connectTo(page, /outrunner/i);
    await fillPlate(page, { "Pole pairs": "700" });
    await button(page, "Next").click();
    await page.locator(".plate .problem").waitFor();
    assert.deepEqual(await violations(page), []);
    await askToMeasure(page);
    assert.deepEqual(await violations(page), []);
    await button(page, "Begin the measurement").click();
    await page.getByText(/^the shaft goes to three angles/).first().waitFor();
    assert.deepEqual(await violations(page), []);
    await page.keyboard.press("Escape");
    await button(page, "Back to the name plate").waitFor();
    assert.deepEqual(await violations(page), []);
}));

test("nothing is wider than the window", async () => withPage(async (page) => {
    await settled(page);
    await assertFits(page, "Simulate");
    await switchOn(page);
    for (const tab of ["Play", "Step", "Replay"]) {
        await openTab(page, tab);
        await assertFits(page, tab);
    }
}));

test("nothing is wider than the window beside a board", async () => withBoard(async (page) => {
    await connectToReady(page);
    for (const panel of ["Parameters", "Signals", "Measure the motor"]) {
        await button(page, panel).click();
        await assertFits(page, panel);
    }
}));

test("all of the page is small", async (t) => {
    const names = await readdir(setting("NF_WEB"));
    const sizes = await Promise.all(names.map(async (name) => gzipSync(await readFile(join(setting("NF_WEB"), name)), { level: 9 }).length));
    const sum = sizes.reduce((a, b) => a + b, 0);
    t.diagnostic(`${sum} bytes compressed`);
    assert.ok(sum > 0 && sum <= BYTES_MAX, `${sum} bytes compressed; allowed: at most ${BYTES_MAX}`);
});
