// SPDX-License-Identifier: MIT
// The tab Replay, used as a person would, beside `motorsim replay`.
import assert from "node:assert/strict";
import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { test } from "node:test";
import { settled, motorsim, openTab, recordedFault, withPage } from "./bench.mjs";

async function withLog(test) {
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    try {
        const log = await recordedFault(folder);
        await withPage(async (page) => {
            await settled(page);
            await openTab(page, "Replay");
            await test(page, log);
        });
    } finally {
        await rm(folder, { recursive: true });
    }
}

// A file that is let go over the page.
async function drop(page, path) {
    const bytes = [...await readFile(path)];
    const given = await page.evaluateHandle(([bytes, name]) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([new Uint8Array(bytes)], name));
        return transfer;
    }, [bytes, basename(path)]);
    for (const event of ["dragover", "drop"]) {
        await page.dispatchEvent(".drop", event, { dataTransfer: given });
    }
}

const native = (path) => motorsim(["replay", basename(path)], dirname(path));

test("a dropped log: the program's words, the curves, the stepper at the fault", async () => withLog(async (page, log) => {
    await drop(page, log);
    const summary = page.locator(".summary pre");
    await summary.waitFor();
    const { stdout } = await native(log);
    assert.equal(await summary.innerText(), stdout);
    assert.equal(await page.locator(".plot").count(), 3);
    await page.locator(".u-legend").getByText("speed_estimated_rpm [rpm]").waitFor();
    const tick = /fault at tick (\d+)/.exec(stdout)[1];
    await page.getByRole("button", { name: `Step from tick ${tick}` }).click();
    await page.getByText(`Stages of tick ${tick},`).waitFor();
    await page.locator(".place").getByText("LOST_PHASE").first().waitFor();
    await page.getByRole("columnheader", { name: "Recorded" }).waitFor();
    await page.getByRole("button", { name: "Back one tick" }).click();
    await page.getByText(`Stages of tick ${tick - 1},`).waitFor();
    await page.locator(".place .fault").waitFor({ state: "detached" });
}));

test("a chosen log, and another signal of it", async () => withLog(async (page, log) => {
    await page.getByLabel("Or choose a file").setInputFiles(log);
    await page.getByLabel("Search signals by name or unit").fill("angle_estimated");
    await page.getByLabel("angle_estimated_el_deg").check();
    await page.locator(".u-legend").getByText("angle_estimated_el_deg [deg]").waitFor();
    await openTab(page, "Simulate");
    await openTab(page, "Replay");
    await page.locator(".summary pre").waitFor();
}));

test("without a recording it says where one comes from, and the command for a sample makes one", async () => withLog(async (page, log) => {
    const command = await page.locator(".explained pre").innerText();
    const args = [...command.matchAll(/'[^']*'|\S+/g)].map(([word]) => word.replaceAll("'", ""));
    assert.equal(args[0], "build/host/motorsim");
    const sample = join(dirname(log), "sample");
    await mkdir(sample);
    await motorsim(args.slice(1), sample); // says with its status that the fault breaks the scenario's limits
    await page.getByLabel("Or choose a file").setInputFiles(join(sample, "field.log"));
    await page.locator(".summary pre").getByText("LOST_PHASE").waitFor();
    await page.locator(".explained").waitFor({ state: "detached" });
}));

for (const [what, damage] of [
    ["cut off", (text) => text.slice(0, text.length / 2)],
    ["with a letter changed", (text) => text.replace(/^(.{200}.*?)([A-Y])/s, (_, before, letter) => before + String.fromCharCode(letter.charCodeAt(0) + 1))],
    ["something else", () => "hello\n"],
    ["empty", () => ""],
]) {
    test(`a file that is ${what} gets the program's line`, async () => withLog(async (page, log) => {
        await writeFile(log, damage(await readFile(log, "latin1")), "latin1");
        const { stderr, status } = await native(log);
        assert.equal(status, 2);
        await page.getByLabel("Or choose a file").setInputFiles(log);
        await page.getByRole("alert").waitFor();
        assert.equal(await page.getByRole("alert").innerText(), stderr.trim().replace(/^motorsim: /, ""));
    }));
}
