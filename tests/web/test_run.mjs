// SPDX-License-Identifier: MIT
// The tab Run, used as a person would.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { settled, motorsim, withPage } from "./bench.mjs";

async function downloaded(page, button) {
    const waiting = page.waitForEvent("download");
    await page.getByRole("button", { name: button }).click();
    return readFile(await (await waiting).path());
}

async function figures(page) {
    const rows = await page.locator("table").first().locator("tbody tr").allInnerTexts();
    return Object.fromEntries(rows.map((row) => row.split("\t").slice(0, 2).map((text) => text.split(" ")[0])));
}

test("a scenario with imperfections has the program's figures", async () => withPage(async (page) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s3");
    await page.getByLabel("adc", { exact: true }).check();
    await page.getByText("motorsim run s3 --with adc", { exact: true }).waitFor();
    await page.locator("progress").waitFor({ state: "detached" });
    const { stdout } = await motorsim(["run", "s3", "--with", "adc"]);
    for (const [name, value] of Object.entries(await figures(page)).filter(([name]) => name.includes("_"))) {
        assert.match(stdout, new RegExp(`\\b${name} +${value.replaceAll(".", "\\.")}\\b`), name);
    }
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
    const [near, far] = await range();
    assert.ok(near > from && far < to);
    await page.keyboard.press("Shift+ArrowRight");
    assert.ok((await range())[0] > near);
    await page.keyboard.press("0");
    assert.deepEqual(await range(), [from, to]);
    await page.keyboard.press("ArrowRight");
    await page.locator(".u-legend .u-value").filter({ hasText: /\d/ }).first().waitFor();
}));

test("dragging zooms all panels", async () => withPage(async (page) => {
    await settled(page);
    const box = await page.locator(".u-over").first().boundingBox();
    await page.mouse.move(box.x + box.width * 0.4, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + 20, { steps: 5 });
    await page.mouse.up();
    const ranges = await page.locator(".plot").evaluateAll((plots) =>
        plots.map((plot) => / (\S+) s to (\S+) s/.exec(plot.ariaLabel).slice(1).join()));
    assert.equal(new Set(ranges).size, 1);
    const [from, to] = ranges[0].split(",").map(Number);
    assert.ok(to - from > 0 && to - from < 5);
}));

test("trace and picture can be taken along", async () => withPage(async (page) => {
    await settled(page);
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    await motorsim(["run", "s1_robust", "--trace", join(folder, "trace.csv")]);
    const trace = await downloaded(page, "Download trace (CSV)");
    assert.ok(trace.equals(await readFile(join(folder, "trace.csv"))), "the traces differ");
    const picture = await downloaded(page, "Download picture");
    assert.equal(picture.subarray(1, 4).toString(), "PNG");
    assert.ok(picture.length > 10_000);
    await rm(folder, { recursive: true });
}));
