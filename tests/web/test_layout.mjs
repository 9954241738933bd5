// SPDX-License-Identifier: MIT
// Where the parts of the page are, at the widths of a phone, a tablet, a laptop and a desktop.
import assert from "node:assert/strict";
import { test } from "node:test";
import { button, openTab, settled, switchOn, until, WINDOWS, withPage } from "./bench.mjs";

const [PHONE, , LAPTOP, DESKTOP] = WINDOWS;
const NARROW = [...WINDOWS.slice(0, 2), { width: 900, height: 900 }];
const NAME_MIN_PX = 120; // of a column of names: some 17 letters
const PLOT_SHARE = 0.5; // of the desktop's height, for the areas of all plots

const boxes = (page, selector) => page.locator(selector).evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()));

function overlap(one, other) {
    return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}

for (const size of NARROW) {
    test(`results and curves do not overlap at ${size.width}`, async () => withPage(async (page) => {
        await settled(page);
        const results = await boxes(page, ".results, .results table");
        const curves = await boxes(page, ".toolbar, .panel, .plot canvas");
        assert.ok(results.length >= 2 && curves.length >= 7);
        assert.ok(!results.some((one) => curves.some((other) => overlap(one, other))));
    }, { viewport: size }));
}

test("plots fill a desktop's height, in each view with plots", async () => withPage(async (page) => {
    const sum = async () => (await boxes(page, ".u-over")).reduce((all, { height }) => all + height, 0);
    const isEnough = (height) => height > PLOT_SHARE * DESKTOP.height;
    await settled(page);
    await until(sum, isEnough);
    const [panels] = await boxes(page, ".panels");
    assert.ok(DESKTOP.height - panels.bottom < 20, `${DESKTOP.height - panels.bottom} px are empty below the panels`);
    await switchOn(page);
    await until(sum, isEnough);
}, { viewport: DESKTOP }));

test("plots follow the window's height", async () => withPage(async (page) => {
    await settled(page);
    const [before] = await boxes(page, ".u-over");
    await page.setViewportSize(DESKTOP);
    await until(async () => (await boxes(page, ".u-over"))[0].height, (now) => now > before.height * 1.5);
    await page.setViewportSize(LAPTOP);
    await until(async () => (await boxes(page, ".u-over"))[0].height, (now) => now === before.height);
}));

// Rows of a plot's canvas above the plot's area that have ink, and how many there are.
function inkAbove(page) {
    return page.locator(".plot canvas").first().evaluate((canvas) => {
        const over = canvas.parentElement.querySelector(".u-over");
        const [left, rows, columns] = [over.offsetLeft, over.offsetTop, over.offsetWidth].map((px) => px * devicePixelRatio);
        const { data } = canvas.getContext("2d").getImageData(left, 0, columns, rows);
        const isInked = (row) => data.subarray(row * columns * 4, (row + 1) * columns * 4).some((byte) => byte > 0);
        return { inked: [...Array(rows).keys()].filter(isInked), rows };
    });
}

test("names of states stand whole above the plot", async () => withPage(async (page) => {
    await settled(page);
    const { inked, rows } = await inkAbove(page);
    assert.ok(inked.length >= 6, `${inked.length} rows of letters`);
    assert.ok(inked[0] > 0 && inked.at(-1) < rows - 1, `rows ${inked[0]} to ${inked.at(-1)} of ${rows} have letters`);
}));

test("Step's names are readable on a phone", async () => withPage(async (page) => {
    await settled(page);
    await openTab(page, "Step");
    await page.getByText("Stages of tick 0,").waitFor();
    const width = async () => (await boxes(page, ".tick tbody tr:not(.stage-title) th")).map((box) => box.width);
    assert.ok((await width()).every((px) => px >= NAME_MIN_PX));
    await button(page, "Beside double precision").click();
    await page.getByText(/^Tick 0 beside double precision/).waitFor();
    assert.ok((await width()).every((px) => px >= NAME_MIN_PX));
}, { viewport: PHONE }));

test("no panel hides a part of its legend", async () => withPage(async (page) => {
    await settled(page);
    for (const size of WINDOWS) {
        await page.setViewportSize(size);
        const hidden = await page.locator(".panel").evaluateAll((panels) => panels.filter((panel) => {
            const outer = panel.getBoundingClientRect();
            return [...panel.querySelectorAll(".u-series")].some((one) => one.getBoundingClientRect().right > outer.right + 1);
        }).length);
        assert.equal(hidden, 0, `at ${size.width}`);
    }
}));
