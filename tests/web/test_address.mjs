// SPDX-License-Identifier: MIT
// The address of the page and the browser's history: each view has its own, and Back never leaves what was played.
import assert from "node:assert/strict";
import { test } from "node:test";
import { button, openTab, reading, settled, state, switchOn, type, until, withPage } from "./bench.mjs";

const VIEWS = ["Simulate", "Play", "Step", "Replay", "Connect"];

function isOpen(page, name) {
    return page.getByRole("tab", { name, exact: true, selected: true }).waitFor();
}

const hash = (page) => page.evaluate(() => location.hash.slice(1));

test("Back and Forward go from view to view, and each has its address and its title", async () => withPage(async (page) => {
    await settled(page);
    for (const name of VIEWS) {
        await openTab(page, name);
        await until(() => hash(page), (now) => now === name.toLowerCase());
        await until(() => page.title(), (now) => now === `${name} – neurofoc bench`);
    }
    for (const name of VIEWS.toReversed().slice(1)) {
        await page.goBack();
        await isOpen(page, name);
    }
    for (const name of VIEWS.slice(1)) {
        await page.goForward();
        await isOpen(page, name);
    }
}));

test("what was played is there after Back and Forward", async () => withPage(async (page) => {
    await settled(page);
    await switchOn(page);
    await button(page, "Start motor").click();
    await type(page, "Speed [rpm]", "600");
    await state(page, "RUN");
    await button(page, "Step through this").click();
    await page.getByText(/^Stages of tick/).waitFor();
    await page.goBack();
    await isOpen(page, "Play");
    await button(page, "Go on").click();
    await state(page, "RUN");
    assert.ok((await reading(page, "Speed")) > 0);
    await page.goForward();
    await isOpen(page, "Step");
    assert.equal(await page.getByLabel("Step through").inputValue(), "play");
}));

test("a page that is loaded again opens the same view, with the same choice", async () => withPage(async (page) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s3");
    await page.getByText("motorsim run s3", { exact: true }).waitFor();
    await openTab(page, "Replay");
    await page.reload();
    await isOpen(page, "Replay");
    await page.goBack();
    await isOpen(page, "Simulate");
    await page.getByText("motorsim run s3", { exact: true }).waitFor();
}));

test("Back to an entry of another choice keeps the newest one", async () => withPage(async (page) => {
    await settled(page);
    await openTab(page, "Play");
    await page.getByLabel("Scenario").selectOption("s3");
    await page.goBack();
    await isOpen(page, "Simulate");
    await page.getByText("motorsim run s3", { exact: true }).waitFor();
    await until(() => hash(page), (now) => now.startsWith("simulate="));
}));

test("a link that was sent under the view's old name opens", async () => withPage(async (page, address) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s3");
    const [, choice] = (await until(() => hash(page), (now) => now.includes("="))).split("=");
    await page.goto("about:blank");
    await page.goto(`${address}#run=${choice}`);
    await isOpen(page, "Simulate");
    await page.getByText("motorsim run s3", { exact: true }).waitFor();
}));

test("a link to another choice, typed over this one, opens it", async () => withPage(async (page, address) => {
    await settled(page);
    await page.getByLabel("Scenario").selectOption("s3");
    const [, choice] = (await until(() => hash(page), (now) => now.includes("="))).split("=");
    await page.getByLabel("Scenario").selectOption("s4");
    await page.getByText("motorsim run s4", { exact: true }).waitFor();
    await until(() => hash(page), (now) => !now.endsWith(choice));
    await page.goto(`${address}#simulate=${choice}`);
    await page.getByText("motorsim run s3", { exact: true }).waitFor();
}));

test("a damaged link is told in each view that needs it", async () => withPage(async (page, address) => {
    for (const view of ["simulate", "play"]) {
        await page.goto("about:blank");
        await page.goto(`${address}#${view}=nonsense`);
        await page.getByText("The link is damaged; this is the first scenario in its place.").waitFor();
    }
}));
