// SPDX-License-Identifier: MIT
// A board out of the box and a motor of which only the name plate is known: all that a person does with them in the page, and what
// the page says to what cannot be.
import assert from "node:assert/strict";
import { copyFile, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { violations } from "./axe.mjs";
import { button, downloaded, ROOT, state, until } from "./bench.mjs";
import { run, valueOf } from "./connected.mjs";
import { atPace, connectTo, outOfTheBox } from "./out_of_the_box.mjs";
import { askToMeasure, fill, fillPlate, plate, PLATE } from "./plate.mjs";

const STEPS = 23; // of a person, from Connect to the second board
const EXAMPLE = join(ROOT, "host_sim/motors/outrunner_24v.toml"); // of the image
// What is measured, its key, and of how much more the machine has than the example.
const SCALES = { resistance: ["resistance_ohm", 1.6], inductance_d: ["inductance_d_h", 1.5], flux_linkage: ["flux_linkage_wb", 0.7] };
const TOGETHER = { "motor.max_speed_rpm": "4000", "tuning.command_timeout_s": "1", "observer.kappa": "0.02" };

const problem = (page) => plate(page).locator(".problem");

async function begin(page) {
    await fillPlate(page);
    await askToMeasure(page);
    await button(page, "Begin the measurement").click();
    await page.getByText(/^pulses on each phase, the shaft hardly moves/).first().waitFor();
}

// The answer to a line, whole. What the board says unasked may stand before it.
async function tell(page, line) {
    const said = () => page.getByRole("log").locator("> *").allInnerTexts();
    const before = (await said()).length;
    await page.getByLabel(/^Command \(/).fill(line);
    await page.keyboard.press("Enter");
    const answers = (all) => all.slice(Math.max(all.lastIndexOf(`> ${line}`), before) + 1).filter((one) => !one.startsWith("board: "));
    return answers(await until(said, (all) => answers(all).length > 0)).join("\n");
}

// Of a motor file: the number behind a key.
function numberIn(text, key) {
    return Number(new RegExp(`^${key} = (\\S+)`, "m").exec(text)?.[1] ?? 0);
}

function assertMeasured(measured, example) {
    for (const [what, [key, scale]] of Object.entries(SCALES)) {
        const bars = ["std", "bound"].map((kind) => numberIn(measured, `${what}_${kind}_pct`) / 100);
        const off = numberIn(measured, key) / (numberIn(example, key) * scale) - 1;
        assert.ok(Math.abs(off) <= Math.hypot(2 * bars[0], bars[1]), `${key} is ${100 * off} % off`);
    }
}

// Each step is what a person does: a click, or a field that is filled. It is counted, and named where it fails.
class Steps {
    count = 0;

    async do(what, act) {
        this.count++;
        try {
            return await act();
        } catch (error) {
            throw new Error(`step ${this.count}, ${what}: ${error.message}`, { cause: error });
        }
    }
}

async function measure(page, steps) {
    const press = (name) => steps.do(name, () => button(page, name).click());
    await press("Measure the motor");
    for (const [label, text] of Object.entries(PLATE)) {
        await steps.do(label, () => fill(page, label, text));
    }
    await press("Next");
    const seen = await page.getByRole("region", { name: "Before it begins" }).innerText();
    assert.match(seen, /up to 27 A, at three angles[^]* up to 15 A[^]* at up to 3333 rpm[^]*never asks for more than 30 A[^]*turn freely/);
    await press("Begin the measurement");
    await page.getByText(/^the shaft turns, up to \d+ rpm/).first().waitFor();
    await page.getByRole("button", { name: /^Download .*toml$/ }).waitFor();
    const rows = await page.locator("table.measured tbody tr").allInnerTexts();
    assert.ok(rows.some((row) => /^R\s+[\d.]+\s+[\d.e-]+\s+ohm$/.test(row)), rows.join("; "));
    assert.deepEqual(await violations(page), []);
    const file = await steps.do("Download", () => downloaded(page, /^Download .*toml$/));
    await press("Adopt");
    await page.getByText("adopt out_of_the_drawer_measured: ok").waitFor();
    await press("Store");
    await page.getByText("store: ok").waitFor();
    return file;
}

test(`from a name plate to a second board with the same block: ${STEPS} steps in the page`, async (t) =>
    outOfTheBox(async (page, { cable, board, makeBoard, folder }) => {
        const steps = new Steps();
        await steps.do("Connect", () => connectTo(page, /outrunner/i));
        const measured = await readFile(await measure(page, steps), "utf8");
        assertMeasured(measured, await readFile(EXAMPLE, "utf8"));
        const stored = await tell(page, "get");

        await steps.do("switch off and on", async () => {
            await board.switchOff();
            await cable.plug(await makeBoard("first"));
        });
        await steps.do("Connect", () => connectTo(page, /out of the drawer/));
        assert.equal(await tell(page, "get"), stored);
        await steps.do("Parameters", () => button(page, "Parameters").click());
        for (const [key, value] of Object.entries(TOGETHER)) {
            await steps.do(key, () => page.getByLabel(`New value of ${key}`, { exact: true }).fill(value));
        }
        await steps.do("Set", () => button(page, "Set 3 keys together").click());
        await page.getByRole("complementary", { name: "Parameters" }).getByText(/^ok: .* and \d+ more$/).waitFor();
        const changed = await tell(page, "get");
        const block = join(folder, "mine.nfb");
        await copyFile(await steps.do("Download block", () => downloaded(page, "Download block")), block);

        await steps.do("plug in another board", async () => cable.plug(await makeBoard("second")));
        await steps.do("Connect", () => connectTo(page, /outrunner/i));
        await steps.do("load", () => page.getByLabel("Choose a block or a motor file").setInputFiles(block));
        await page.locator(".board-name").getByText(/out of the drawer/).waitFor();
        assert.equal(await tell(page, "get"), changed);
        t.diagnostic(`${steps.count} steps`);
        assert.equal(steps.count, STEPS);
    }));

// As a person drops it.
async function drop(page, place, name, text) {
    const files = await page.evaluateHandle(([file, content]) => {
        const data = new DataTransfer();
        data.items.add(new File([content], file));
        return data;
    }, [name, text]);
    await place.locator(".drop").dispatchEvent("drop", { dataTransfer: files });
}

// The page's line to a field with this text, while all others are right.
async function lineOf(page, label, text) {
    await fill(page, label, text);
    await button(page, "Next").click();
    const line = await problem(page).innerText();
    assert.equal(await plate(page).getByLabel(label).getAttribute("aria-invalid"), "true", line);
    await fill(page, label, PLATE[label]);
    return line;
}

test("a name plate that cannot be gets a line with field, value and range, and nothing moves", async () =>
    outOfTheBox(async (page) => {
        await connectTo(page, /outrunner/i);
        const before = await tell(page, "get");
        await fillPlate(page);
        for (const [label, text, line] of [
            ["Pole pairs", "0", /motor\.pole_pairs = 0: .*; allowed: a whole number, 1 to 50$/],
            ["Pole pairs", "3.5", /motor\.pole_pairs = 3\.5: .*; allowed: a whole number, 1 to 50$/],
            ["Largest speed [rpm]", "", /^Largest speed, motor\.max_speed_rpm = ""; allowed: 1 to 200000 rpm$/],
            ["Continuous current, peak [A]", "a lot", /^Continuous current, peak, motor\.continuous_current_a = "a lot"; allowed: 0 to 1000 A$/],
            ["Largest current, peak [A]", "3000000", /motor\.max_current_a = 3000000: .*; allowed: 0\.01 to 1000 A$/],
            ["Largest current, peak [A]", "900", /motor\.max_current_a = 900: .*; allowed: /],
            ["Name", "", /^Name, motor\.name = ""; allowed: /],
        ]) {
            assert.match(await lineOf(page, label, text), line);
        }
        await drop(page, plate(page), "holiday.toml", "[scenario]\n");
        await problem(page).getByText(/^holiday\.toml:1: /).waitFor();
        await drop(page, plate(page), "photo.jpg", "\xff\xd8\xff");
        await problem(page).getByText(/^photo\.jpg:1: /).waitFor();
        assert.equal(await button(page, "Begin the measurement").count(), 0);
        await state(page, "READY");
        assert.equal(await tell(page, "get"), before);
    }));

test("a motor file's name plate fills the fields, and Back leaves the board as it was", async () =>
    outOfTheBox(async (page) => {
        await connectTo(page, /outrunner/i);
        const before = await tell(page, "get");
        await button(page, "Measure the motor").click();
        await drop(page, plate(page), "mine.toml", await readFile(EXAMPLE, "utf8"));
        await until(() => plate(page).getByLabel("Pole pairs").inputValue(), (text) => text === "7");
        await askToMeasure(page, {});
        await button(page, "Back").click();
        await plate(page).waitFor();
        assert.equal(await tell(page, "get"), before);
    }));

test("Stop ends a measurement in its midst; the motor may be measured again", async () =>
    outOfTheBox(async (page) => {
        await connectTo(page, /outrunner/i);
        await begin(page);
        assert.match(await tell(page, "set observer.kappa=0.02"), /the motor is being measured; stop ends that/);
        await page.getByText(/^the shaft goes to three angles/).first().waitFor();
        await button(page, "Stop the measurement").click();
        await page.getByRole("alert").getByText("identify: a stop has ended it").waitFor();
        await state(page, "READY");
        await button(page, "Back to the name plate").click();
        await askToMeasure(page, {}); // the fields have what was typed
        await button(page, "Begin the measurement").click();
        await page.locator(".phases").getByText(/^the shaft goes to three angles/).waitFor();
    }));

test("a motor that runs is not measured, and runs on with what it has", async () =>
    outOfTheBox(async (page) => {
        await connectTo(page, /outrunner/i);
        const before = await tell(page, "get");
        await fillPlate(page);
        await askToMeasure(page);
        await run(page, 1000);
        await button(page, "Begin the measurement").click();
        await page.getByRole("alert").getByText("identify: the motor is asked to run; `stop` first").waitFor();
        await state(page, "RUN");
        assert.equal(await tell(page, "get"), before);
    }));

test("a board that goes away in the midst is told of at its place", async () =>
    outOfTheBox(async (page, { cable }) => {
        await connectTo(page, /outrunner/i);
        await begin(page);
        await cable.pull();
        await page.getByRole("alert").getByText(/^the connection ended before the measurement did/).waitFor();
        await connectTo(page, /out of the drawer/, "PROBE"); // it goes on measuring
        await button(page, "Stop").click();
        await state(page, "READY");
    }));

test("a file that is no block or no motor gets a line, and changes nothing", async () =>
    outOfTheBox(async (page) => {
        await connectTo(page, /outrunner/i);
        const before = await tell(page, "get");
        await button(page, "Parameters").click();
        const panel = page.getByRole("complementary", { name: "Parameters" });
        for (const [name, text, line] of [
            ["photo.jpg", "\xff\xd8\xff", /^photo\.jpg: the file's length: found \d+ bytes, expected \d+/],
            ["empty.nfb", "", /^empty\.nfb: the file's length: found 0 bytes/],
            ["other.nfb", "x".repeat(1000), /^other\.nfb: .*found/],
            ["plate.toml", '[motor]\nname = "x"\npole_pairs = 7\n', /^plate\.toml:1: .* are missing/],
            ["wrong.toml", "[motor]\npole_pairs = 700\n", /^wrong\.toml:2: motor\.pole_pairs = 700: .*; allowed: a whole number, 1 to 50/],
        ]) {
            await drop(page, panel, name, text);
            await panel.locator(".problem").getByText(line).waitFor();
        }
        assert.equal(await tell(page, "get"), before);
    }));

test("a page that is loaded anew follows a board with a motor of its own; its file, chosen before, gives the keys", async () =>
    outOfTheBox(async (page, { cable, folder }) => {
        const text = (await readFile(EXAMPLE, "utf8")).replace(/^name = .*$/m, 'name = "mine"');
        const mine = join(folder, "mine.toml");
        await writeFile(mine, text);
        await connectTo(page, /outrunner/i);
        await button(page, "Parameters").click();
        await page.getByLabel("Choose a block or a motor file").setInputFiles(mine);
        await page.locator(".board-name").getByText(/mine/).waitFor();
        await cable.close();
        await page.reload();
        await atPace(page);
        await connectTo(page, /mine/);
        await button(page, "Parameters").click();
        await page.getByText(/no shipped files make the board's "neurofoc: mine, /).waitFor();
        await button(page, "Disconnect").click();
        await page.getByText("Files of the board").click();
        await page.getByLabel("Choose a motor file").setInputFiles(mine);
        await page.getByText("mine.toml: known until the page is loaded anew").waitFor();
        await connectTo(page, /mine/);
        await until(() => valueOf(page, "motor.max_speed_rpm"), (value) => value === "5000");
    }));
