// SPDX-License-Identifier: MIT
// The tab Play, used as a person would. How fast it is, is printed: NF_PLAY_S is how long that is watched.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
    button, openFile, openTab, reading, reads, replaceLine, settled, state, switchOn, type, until, withPage,
} from "./bench.mjs";

const WATCHED_S = Number(process.env.NF_PLAY_S ?? 5);
const SPEED_RPM = 600;
const SPEED_NEAR_RPM = 30; // 5 %

async function running(page, scenario = "s1_robust") {
    await settled(page);
    await page.getByLabel("Scenario").selectOption(scenario);
    await switchOn(page);
    await button(page, "Start motor").click();
    await type(page, "Speed [rpm]", String(SPEED_RPM));
    await state(page, "RUN");
}

test("it follows a speed, and bears a load", async () => withPage(async (page) => {
    await running(page);
    await reads(page, "Speed", (rpm) => Math.abs(rpm - SPEED_RPM) < SPEED_NEAR_RPM);
    const before = await reading(page, "Torque");
    await type(page, "Load torque [N·m]", "2");
    await reads(page, "Torque", (nm) => nm > before + 1.5);
    await button(page, "Stop").click();
    await state(page, "READY");
}));

test("readings have the decimals of their quantity", async () => withPage(async (page) => {
    await running(page);
    await page.locator("caption").filter({ hasText: "Now" }).waitFor();
    for (const text of await page.locator(".readings td").allInnerTexts()) {
        assert.match(text, /^-?\d+(\.\d{1,4})? \S+$/);
    }
}));

// Where the rotor has come to rest. A speed near 0 is not enough: there a rotor also turns back.
async function restingPosition(page) {
    let at;
    await until(async () => {
        const before = await reading(page, "Rotor position");
        await new Promise((resolve) => setTimeout(resolve, 300));
        at = await reading(page, "Rotor position");
        return at - before;
    }, (way) => Math.abs(way) < 0.1);
    return at;
}

test("it goes to a position", async () => withPage(async (page) => {
    await running(page);
    await page.getByLabel("position", { exact: true }).check();
    const at = await restingPosition(page);
    await type(page, "Position [°]", "360");
    await reads(page, "Rotor position", (rad) => Math.abs(rad - at - 2 * Math.PI) < 0.5);
}));

test("it makes a torque, and bears as much with it", async () => withPage(async (page) => {
    await running(page);
    await page.getByLabel("torque", { exact: true }).check();
    await type(page, "Load torque [N·m]", "2");
    await type(page, "Torque command [N·m]", "2");
    await reads(page, "Torque", (nm) => Math.abs(nm - 2) < 0.2);
    await type(page, "Torque command [N·m]", "999");
    await page.getByText(/^torque = 999 N·m; allowed: -[\d.]+ to [\d.]+ N·m$/).waitFor();
}));

test("keys turn a knob, and a wild number is refused in a line", async () => withPage(async (page) => {
    await running(page);
    await page.getByLabel("Speed slider, in rpm").focus();
    await page.keyboard.press("ArrowRight");
    await reads(page, "Speed", (rpm) => Math.abs(rpm - SPEED_RPM - 10) < 8);
    await type(page, "Speed [rpm]", "99999");
    await page.getByText(/^speed = 99999 rpm; allowed: -\d+ to \d+ rpm$/).waitFor();
}));

test("a broken phase is a fault with advice; the tick before it can be seen; repaired, it runs again", async () => withPage(async (page) => {
    await running(page);
    await button(page, "Open phase a").click();
    await state(page, "FAULT");
    const card = page.locator(".fault");
    assert.match(await card.innerText(), /^[A-Z_]+ at [\d.]+ s\s+\S.*, limit .*\s+\w.*; \w/);
    const name = /^\S+/.exec(await card.innerText())[0];
    await button(page, "Step through this").click();
    await button(page, "To the tick before the fault").click();
    await page.locator(".place .fault").waitFor({ state: "detached" });
    assert.match(await page.locator(".place").innerText(), /^tick \d+ .* RUN /);
    await button(page, "Step one tick").click();
    await page.locator(".place .fault").getByText(name).waitFor();
    await page.getByText(/^Changes/).click();
    await page.getByText(/^phase_a_open at tick \d+$/).waitFor();

    await openTab(page, "Play");
    await button(page, "Go on").click();
    await state(page, "FAULT");
    await button(page, "Open phase a").click();
    await button(page, "Clear fault").click();
    await state(page, "READY");
    await button(page, "Start motor").click();
    await state(page, "RUN");
}));

for (const name of ["Stuck current sensor a", "Blocked rotor", /^Bus dip/]) {
    test(`${name}: it is noticed`, async () => withPage(async (page) => {
        await running(page);
        await page.getByRole("button", { name }).click();
        await state(page, "FAULT");
    }));
}

test("a stuck angle sensor is noticed, and there is one where the drive has one", async () => withPage(async (page) => {
    await running(page, "s4");
    await type(page, "Load torque [N·m]", "3");
    await reads(page, "Torque", (nm) => nm > 2);
    await button(page, "Stuck angle sensor").click();
    await state(page, "FAULT");
}));

test("a jump of the rotor shows in the error of the angle", async () => withPage(async (page) => {
    await running(page);
    await page.getByLabel("Time ×").selectOption("1/1000");
    const error = async () => Number(/error θ − θ̂ (\S+)°/.exec(await page.locator(".legend").innerText())?.[1]);
    const before = await error();
    await button(page, "Rotor jump by 90°").click();
    await until(error, (now) => Math.abs(now - before) > 60);
}));

test("a signal is found and shown; time stands still in a pause", async () => withPage(async (page) => {
    await running(page);
    await button(page, "Signals").click();
    await page.getByLabel("Search signals by name or unit").fill("load_torque");
    await page.getByLabel("load_torque_nm").check();
    await page.locator(".u-legend").getByText("load_torque_nm [N m]").waitFor();
    await button(page, "Pause").click();
    await page.getByText("paused", { exact: true }).waitFor();
    const caption = page.locator("caption").filter({ hasText: "Now, t" });
    // What was under way when the button was pressed comes first; then time stands still over some refreshes.
    const twice = async () => [await caption.innerText(), await page.waitForTimeout(300), await caption.innerText()];
    await until(twice, ([now, , later]) => now === later);
}));

test("it is the machine of the scenario, with its edited files", async () => withPage(async (page) => {
    await settled(page);
    await replaceLine(page, await openFile(page, "motors/motor_a.toml", "resistance_ohm"), "resistance_ohm = -3");
    await openTab(page, "Play");
    await button(page, "Switch the machine on").click();
    await page.getByText(/^motors\/motor_a\.toml:\d+: motor\.resistance_ohm = -3: .*allowed: .*Ω$/).waitFor();
}));

test("time goes by", async (t) => withPage(async (page) => {
    await running(page);
    const pace = page.locator(".pace");
    const dropped = async () => Number(/(\d+) dropped/.exec(await pace.innerText())?.[1]);
    const now = async () => Number(/t = ([\d.]+) s/.exec(await page.locator("caption").filter({ hasText: "Now" }).innerText())[1]);
    const [lost, from, began] = [await dropped(), await now(), performance.now()];
    const frames = await page.evaluate((ms) => new Promise((resolve) => {
        let count = 0;
        const end = performance.now() + ms;
        const next = (at) => (at < end ? (count++, requestAnimationFrame(next)) : resolve(count));
        requestAnimationFrame(next);
    }), WATCHED_S * 1000);
    const passed = (performance.now() - began) / 1000;
    const ratio = ((await now()) - from) / passed;
    t.diagnostic(`${passed.toFixed(1)} s: ${ratio.toFixed(3)} x real time, ${(frames / passed).toFixed(1)} frames/s, ` +
        `${(await dropped()) - lost} dropped frames`);
    assert.ok((await now()) > from);
}));
