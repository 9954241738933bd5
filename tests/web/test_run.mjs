// SPDX-License-Identifier: MIT
// The tab Simulate, used as a person would.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { downloaded, motorsim, openFile, replaceLine, settled, until, withPage } from "./bench.mjs";

// In the page: notes when the results of the first run are in the document.
function noteFirstResults() {
    addEventListener("DOMContentLoaded", () => {
        new MutationObserver((_, observer) => {
            if (document.querySelector("section[aria-label=Results]") !== null) {
                performance.mark("first results");
                observer.disconnect();
            }
        }).observe(document.body, { childList: true, subtree: true });
    });
}

test("the first run begins by itself", async (t) => withPage(async (page) => {
    await settled(page);
    const [loadedMs, shownMs] = await page.evaluate(() => [
        performance.getEntriesByType("navigation")[0].loadEventEnd,
        performance.getEntriesByName("first results")[0].startTime,
    ]);
    const run = /^(\d+ ticks in \d+ ms)/.exec(await page.getByText(/^\d+ ticks in/).innerText())[1];
    // A figure of this machine at this moment: it is told, not judged.
    t.diagnostic(`results of s1_robust ${Math.round(shownMs - loadedMs)} ms after load; ${run}`);
    assert.ok(shownMs > 0);
}, { init: noteFirstResults }));

async function figures(page) {
    const rows = await page.locator("table").first().locator("tbody tr").allInnerTexts();
    return Object.fromEntries(rows.map((row) => row.split("\t").slice(0, 2).map((text) => text.split(" ")[0])));
}

test("a scenario with imperfections has the program's figures", async () => withPage(async (page) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s3");
    await page.getByLabel("adc", { exact: true }).check();
    await page.getByText("motorsim run s3 --with adc", { exact: true }).waitFor();
    await settled(page);
    const { stdout } = await motorsim(["run", "s3", "--with", "adc"]);
    for (const [name, value] of Object.entries(await figures(page)).filter(([name]) => name.includes("_"))) {
        assert.match(stdout, new RegExp(`\\b${name} +${value.replaceAll(".", "\\.")}\\b`), name);
    }
}));

// Pixels of curves in the first panel: the grounds behind them shine through more than the faintest curve.
function coloured(page) {
    return page.locator(".plot canvas").first().evaluate((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const GROUND_ALPHA = 60;
        let count = 0;
        for (let at = 0; at < data.length; at += 4) {
            const [red, green, blue] = data.subarray(at, at + 3);
            count += Math.max(red, green, blue) - Math.min(red, green, blue) > 40 && data[at + 3] > GROUND_ALPHA ? 1 : 0;
        }
        return count;
    });
}

test("an edit's effect stands beside the run before it, in figures and curves", async () => withPage(async (page) => {
    await settled(page);
    const first = await figures(page);
    await replaceLine(page, await openFile(page, "motors/motor_a.toml", "inertia_kg_m2"), "inertia_kg_m2 = 0.03");
    await page.getByRole("button", { name: "Simulate" }).click();
    await page.getByRole("columnheader", { name: "Before" }).waitFor();
    const before = await page.locator("tr").filter({ hasText: "speed_error_rms_rpm" }).locator(".before").innerText();
    assert.equal(before.split(" ")[0], first.speed_error_rms_rpm);
    assert.notEqual((await figures(page)).speed_error_rms_rpm, first.speed_error_rms_rpm);
    await page.getByRole("button", { name: "Curves" }).click();
    await page.getByRole("group", { name: /^Panel 1: speed_command_rpm.*, and of the run before, / }).waitFor();
    const compared = await coloured(page);
    await page.getByRole("button", { name: "Curves before" }).click();
    await page.getByRole("group", { name: /^Panel 1: speed_command_rpm(?!.*before)/ }).waitFor();
    const alone = await coloured(page);
    assert.ok(alone > 100 && compared > 1.1 * alone, `${alone} pixels of curves, ${compared} with those of the run before`);
}));

test("a signal that is not known at the beginning is drawn from where it is, and the others with it", async () => withPage(async (page) => {
    await settled(page);
    await page.getByRole("group", { name: /^Panel 1: speed_command_rpm rpm, speed_rpm rpm, speed_estimated_rpm/ }).waitFor();
    await until(() => coloured(page), (pixels) => pixels > 100);
}));

test("a signal is found by name and unit, and drawn", async () => withPage(async (page) => {
    await settled(page);
    await page.getByLabel("Search signals by name or unit").fill("torque n·m");
    const tree = page.getByRole("region", { name: "Signals" });
    assert.match(await tree.getByRole("status").innerText(), /^[1-9]\d? of \d{3} signals$/);
    await page.getByRole("button", { name: "Add panel" }).click();
    await page.getByRole("button", { name: "Panel 4", exact: true }).click();
    await tree.getByLabel("load_torque_nm").check();
    await page.locator(".u-legend").getByText("load_torque_nm [N m]").waitFor();
}));

test("keys zoom, pan and move the cursor", async () => withPage(async (page) => {
    await settled(page);
    const plot = page.locator(".plot").first();
    const range = async () => /([-\d.e]+) s to ([-\d.e]+) s/.exec(await plot.getAttribute("aria-label")).slice(1).map(Number);
    const [from, to] = await range();
    await plot.focus();
    await page.keyboard.press("+");
    const [near] = await until(range, ([left, right]) => left > from && right < to);
    await page.keyboard.press("Shift+ArrowRight");
    await until(range, ([left]) => left > near);
    await page.keyboard.press("0");
    await until(range, ([left, right]) => left === from && right === to);
    await page.keyboard.press("ArrowRight");
    await page.locator(".u-legend .u-value").filter({ hasText: /\d/ }).first().waitFor();
}));

test("dragging zooms all panels", async () => withPage(async (page) => {
    await settled(page);
    const ranges = () => page.locator(".plot").evaluateAll((plots) =>
        plots.map((plot) => / (\S+) s to (\S+) s/.exec(plot.ariaLabel).slice(1).join()));
    const [whole] = await ranges();
    const box = await page.locator(".u-over").first().boundingBox();
    await page.mouse.move(box.x + box.width * 0.4, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + 20, { steps: 5 });
    await page.mouse.up();
    const width = (range) => range.split(",").map(Number).reduce((from, to) => to - from);
    const [zoomed] = await until(ranges, (all) => new Set(all).size === 1 && all[0] !== whole);
    const share = width(zoomed) / width(whole);
    assert.ok(share > 0.15 && share < 0.25, `a fifth was marked, ${share} is shown`);
}));

test("a trace that is written can be stopped", async () => withPage(async (page) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s4");
    await page.getByText("motorsim run s4", { exact: true }).waitFor();
    // So long that nobody is too late.
    await replaceLine(page, await openFile(page, "scenarios/s4.toml", "duration_s = "), "duration_s = 300");
    await page.getByText("motorsim run scenarios/s4.toml", { exact: true }).waitFor();
    await page.getByRole("button", { name: "Download trace (CSV)" }).click();
    await page.getByRole("button", { name: /^Stop the trace/ }).click();
    await page.getByText("The trace was stopped.").waitFor();
    await page.getByRole("button", { name: "Download trace (CSV)" }).waitFor();
}));

test("trace, results and picture can be taken along", async () => withPage(async (page) => {
    await settled(page);
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    await motorsim(["run", "s1_robust", "--trace", join(folder, "trace.csv")]);
    const trace = await readFile(await downloaded(page, "Download trace (CSV)"));
    assert.ok(trace.equals(await readFile(join(folder, "trace.csv"))), "the traces differ");
    const { stdout } = await motorsim(["run", "s1_robust", "--json", "-"]);
    assert.equal((await readFile(await downloaded(page, "Download results (JSON)"))).toString(), stdout);
    const picture = await readFile(await downloaded(page, "Download picture"));
    assert.equal(picture.subarray(1, 4).toString(), "PNG");
    assert.ok(picture.length > 10_000);
    await rm(folder, { recursive: true });
}));
