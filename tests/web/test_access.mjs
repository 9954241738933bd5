// SPDX-License-Identifier: MIT
// axe-core finds nothing in any view, light and dark; a small window and a tablet show all; what the page weighs.
import assert from "node:assert/strict";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { button, openTab, packages, recordedFault, setting, settled, state, switchOn, withPage } from "./bench.mjs";
import { connectToReady, run, setKey, withBoard } from "./connected.mjs";

const BYTES_MAX = 700_000; // with gzip -9, which each static server has
const TABLET = { width: 820, height: 1180 };

async function violations(page) {
    await page.addScriptTag({ content: await readFile(packages.resolve("axe-core/axe.min.js"), "utf8") });
    const { violations: found } = await page.evaluate(() => globalThis.axe.run());
    return found.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`);
}

for (const colorScheme of ["light", "dark"]) {
    test(`axe-core finds nothing, ${colorScheme}`, async () => withPage(async (page) => {
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
        await page.getByLabel("Or choose a file").setInputFiles(await recordedFault(folder));
        await page.getByRole("button", { name: /^Step from tick/ }).waitFor();
        assert.deepEqual(await violations(page), []);
        await rm(folder, { recursive: true });
        await openTab(page, "Connect");
        await page.getByRole("heading", { name: /Web Serial/ }).waitFor();
        assert.deepEqual(await violations(page), []);
    }, { colorScheme, init: () => delete Navigator.prototype.serial }));

    test(`axe-core finds nothing beside a board, ${colorScheme}`, async () => withBoard(async (page, cable) => {
        assert.deepEqual(await violations(page), []);
        await connectToReady(page);
        await run(page);
        await button(page, "Parameters").click();
        await setKey(page, "board.temperature_max_c", "20"); // the simulated power stage has 25 °C
        await state(page, "FAULT");
        assert.deepEqual(await violations(page), []);
        await openTab(page, "Run");
        assert.deepEqual(await violations(page), []);
        await openTab(page, "Connect");
        await cable.pull();
        await button(page, "Connect").waitFor();
        assert.deepEqual(await violations(page), []);
    }, undefined, { colorScheme }));
}

test("nothing is wider than the window", async () => withPage(async (page) => {
    await settled(page);
    const beyond = () => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok((await beyond()) <= 0);
    await page.setViewportSize(TABLET);
    assert.ok((await beyond()) <= 0);
    await switchOn(page);
    for (const tab of ["Play", "Step", "Replay"]) {
        await openTab(page, tab);
        assert.ok((await beyond()) <= 0, tab);
    }
}));

test("nothing is wider than the window beside a board", async () => withBoard(async (page) => {
    await connectToReady(page);
    const beyond = () => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    for (const panel of ["Parameters", "Signals"]) {
        await button(page, panel).click();
        for (const size of [page.viewportSize(), TABLET]) {
            await page.setViewportSize(size);
            assert.ok((await beyond()) <= 0, `${panel} at ${size.width}`);
        }
    }
}));

test("all of the page is small", async (t) => {
    const names = await readdir(setting("NF_WEB"));
    const sizes = await Promise.all(names.map(async (name) => gzipSync(await readFile(join(setting("NF_WEB"), name)), { level: 9 }).length));
    const sum = sizes.reduce((a, b) => a + b, 0);
    t.diagnostic(`${sum} bytes compressed`);
    assert.ok(sum > 0 && sum <= BYTES_MAX, `${sum} bytes compressed; allowed: at most ${BYTES_MAX}`);
});
