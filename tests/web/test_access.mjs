// SPDX-License-Identifier: MIT
// axe-core finds nothing in any view, light and dark; a small window and a tablet show all; what the page weighs.
import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { settled, packages, setting, withPage } from "./bench.mjs";

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
    }, { colorScheme }));
}

test("nothing is wider than the window", async () => withPage(async (page) => {
    await settled(page);
    const beyond = () => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok((await beyond()) <= 0);
    await page.setViewportSize(TABLET);
    assert.ok((await beyond()) <= 0);
}));

test("all of the page is small", async (t) => {
    const names = await readdir(setting("NF_WEB"));
    const sizes = await Promise.all(names.map(async (name) => gzipSync(await readFile(join(setting("NF_WEB"), name)), { level: 9 }).length));
    const sum = sizes.reduce((a, b) => a + b, 0);
    t.diagnostic(`${sum} bytes compressed`);
    assert.ok(sum > 0 && sum <= BYTES_MAX, `${sum} bytes compressed; allowed: at most ${BYTES_MAX}`);
});
