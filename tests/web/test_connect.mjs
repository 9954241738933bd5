// SPDX-License-Identifier: MIT
// The tab Connect, used as a person would, beside boards on pseudo-terminals: the simulated one, and the image in the emulator.
import assert from "node:assert/strict";
import { copyFile, mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { button, downloaded, motorsim, openTab, reading, reads, state, switchOn, until, type, withPage } from "./bench.mjs";
import { EMULATED_PACE, emulatedBoard, simulatedBoard } from "./board.mjs";
import { BAUD, connect, connectToReady, run, setKey, SPEED_RPM, valueOf, withBoard } from "./connected.mjs";
import { otherFirmware, printer } from "./strangers.mjs";

const LOAD_NM = 2;
// Of host_sim/boards, and of a board file that names none.
const KNOWN_RATES = [921600, 460800, 115200];
const LOADED_A = 2 * LOAD_NM / 3 / 2 / 0.387 / 2; // half of torque over 3/2 · pole pairs · flux

const LOCKED = /^board\.temperature_max_c: the board refuses: \S+ protects less than what is in force; stop the drive and unlock first$/;

// To the line that was asked last.
function answers(page, line, text) {
    return until(() => page.getByRole("log").locator("> *").allInnerTexts(), (said) => {
        const at = said.lastIndexOf(`> ${line}`);
        return at >= 0 && said.slice(at + 1).some((answer) => text.test(answer));
    });
}

async function tell(page, line) {
    await page.getByLabel(/^Command \(/).fill(line);
    await page.keyboard.press("Enter");
}

// In the table of parameters, below the key.
function keyAnswers(page, key, text) {
    const body = page.locator("table.keys tbody").filter({ has: page.getByRole("rowheader", { name: key, exact: true }) });
    return body.getByRole("status").filter({ hasText: text }).waitFor();
}

test("a page without Web Serial says so, and names the program that connects", async () => withPage(async (page) => {
    await openTab(page, "Connect");
    await page.getByText(/Web Serial/).first().waitFor();
    await page.getByText(/motorsim live/).first().waitFor();
}, { init: () => delete Navigator.prototype.serial }));

test("without the server's headers the page asks to be loaded once more, and connects", async () => withBoard(async (page) => {
    await button(page, "Load the page once more").click();
    await connect(page); // the page has opened Connect again
}, simulatedBoard, { isPlain: true }));

test("a board is identified and followed; Start motor and a speed bring it there", async () => withBoard(async (page) => {
    await connectToReady(page);
    assert.equal(await page.evaluate(() => globalThis.fakeSerial.opened.baudRate), BAUD);
    await run(page);
    await button(page, "Signals").click();
    await page.getByLabel("Search signals by name or unit").fill("angle_estimated");
    await page.getByLabel("angle_estimated_el_deg").check();
    await page.locator(".u-legend").getByText("angle_estimated_el_deg [deg]").waitFor();
}));

// The board's own pace does not matter to who only asks it.
async function connectAlone(page, boardBaud) {
    await page.evaluate((baud) => (globalThis.fakeSerial.baud = baud), boardBaud);
    await button(page, "Connect").click();
}

const tried = (page) => page.evaluate(() => globalThis.fakeSerial.tried);

test("the rates of the shipped boards are tried, the highest first, and the page names the one that works", async () => withBoard(async (page) => {
    await connectAlone(page, KNOWN_RATES.at(-1));
    await page.getByText(`Waiting for the board to answer at ${KNOWN_RATES[1]} baud…`).waitFor();
    await page.locator(".board-name").getByText(`, at ${KNOWN_RATES.at(-1)} baud`).waitFor();
    assert.deepEqual(await tried(page), KNOWN_RATES);
}));

test("a rate that a person has entered is the only one that is tried", async () => withBoard(async (page) => {
    await type(page, "Baud rate [baud]", "57600");
    await connectAlone(page, KNOWN_RATES[0]);
    await page.getByText("no board answers at 57600 baud; check its power").waitFor();
    assert.deepEqual(await tried(page), [57600]);
}));

test("a person who cancels while the rates are tried may connect again", async () => withBoard(async (page) => {
    await connectAlone(page, KNOWN_RATES.at(-1));
    await button(page, "Cancel").click();
    await page.evaluate(() => (globalThis.fakeSerial.baud = undefined));
    await connect(page);
}));

test("Stop stops the motor, by its button and by Escape", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await button(page, "Stop").click();
    await state(page, "READY");
    await run(page);
    await page.keyboard.press("Escape");
    await state(page, "READY");
}));

test("what waits for its turn when a stop comes is not done after it", async () => withBoard(async (page, _, board) => {
    await connectToReady(page);
    board.freeze();
    await tell(page, "store");
    await button(page, "Start motor").click();
    await page.keyboard.press("Escape");
    board.thaw();
    await answers(page, "store", /^ok$/);
    await page.getByRole("log").getByText("run: not done, a stop came before its turn").waitFor();
    await tell(page, "status");
    await answers(page, "status", /^READY, speed/);
}));

test("a line of the program that the page has elsewhere says where", async () => withBoard(async (page) => {
    await connectToReady(page);
    for (const [line, place] of [["wait 5", /^wait is for scripts$/], ["record x.log", /^press Record$/], ["quit", /^press Disconnect$/]]) {
        await tell(page, line);
        await answers(page, line, place);
    }
}));

test("a position turns the shaft from where it was when position was chosen", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await type(page, "Speed [rpm]", "0");
    await reads(page, "Speed, estimated", (rpm) => Math.abs(rpm) < 1);
    const at = await reading(page, "Position");
    await page.getByLabel("position", { exact: true }).check();
    await type(page, "Position [°]", "360");
    // What speed control has turned does not count any more.
    const before = at - 360 * Math.round(at / 360);
    await reads(page, "Position", (now) => Math.abs(now - before - 360) < 20);
}));

test("a torque turns the shaft up to the end of its window of speeds", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await page.getByLabel("torque", { exact: true }).check();
    await type(page, "Torque command [N·m]", "1.5");
    await reads(page, "Speed, estimated", (rpm) => rpm > SPEED_RPM + 100);
    await page.getByLabel("speed", { exact: true }).check();
    await type(page, "Speed [rpm]", String(SPEED_RPM));
    await reads(page, "Speed, estimated", (rpm) => Math.abs(rpm - SPEED_RPM) < 20);
}));

test("a motor that is left runs on, which is said; whoever connects next finds it so", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await button(page, "Leave it running").click();
    await page.getByText("the motor runs on, and the board does not watch for a PC any more").first().waitFor();
    await connect(page);
    await state(page, "RUN");
    await until(() => page.getByLabel("Speed [rpm]", { exact: true }).inputValue(), (rpm) => Number(rpm) === SPEED_RPM);
}));

test("a fault has its advice; after Clear fault and Start motor the motor turns again", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await button(page, "Parameters").click();
    await setKey(page, "board.temperature_max_c", "20"); // the simulated power stage has 25 °C
    await state(page, "FAULT");
    assert.match(await page.locator(".fault").innerText(), /^OVERTEMPERATURE at [\d.]+ s\s+\S.*, limit .*\s+\w.*; \w/);
    await setKey(page, "board.temperature_max_c", "100");
    await keyAnswers(page, "board.temperature_max_c", LOCKED);
    await button(page, "Unlock").click();
    await setKey(page, "board.temperature_max_c", "100");
    await keyAnswers(page, "board.temperature_max_c", /^ok: /);
    await button(page, "Clear fault").click();
    await state(page, "READY");
    await run(page);
}));

test("Unlock is refused while the motor runs; at rest it is for the next value only", async () => withBoard(async (page) => {
    const key = "board.temperature_max_c";
    await connectToReady(page);
    await run(page);
    await button(page, "Parameters").click();
    await button(page, "Unlock").click();
    await answers(page, "unlock", /^board: error: what protects is unlocked at rest only; stop the drive first$/);
    await button(page, "Stop").click();
    await state(page, "READY");
    await setKey(page, key, "80"); // protects more
    await until(() => valueOf(page, key), (value) => value === "80");
    await setKey(page, key, "85");
    await keyAnswers(page, key, LOCKED);
    await button(page, "Unlock").click();
    await setKey(page, key, "85");
    await until(() => valueOf(page, key), (value) => value === "85");
    await setKey(page, key, "90");
    await keyAnswers(page, key, LOCKED);
    assert.equal(await valueOf(page, key), "85");
    await button(page, "Disconnect").click();
    await page.getByRole("button", { name: "Unlock", exact: true, disabled: true }).waitFor();
}));

test("set acts and names the change; a wrong value gets the program's line", async () => withBoard(async (page) => {
    await connectToReady(page);
    await button(page, "Parameters").click();
    await setKey(page, "observer.kappa", "0.05");
    await answers(page, "set observer.kappa=0.05", /^ok: observer\.eta [\d.]+ to [\d.]+(, |$)/);
    await until(() => valueOf(page, "observer.kappa"), (value) => value === "0.05");
    await setKey(page, "observer.kappa", "5");
    await answers(page, "set observer.kappa=5", /observer\.kappa = 5: is too large; allowed: 0 to 0\.5$/);
    assert.equal(await valueOf(page, "observer.kappa"), "0.05");
}));

test("Store says ok; what is in force is so for whoever connects next, until Adopt files", async () => withBoard(async (page) => {
    await connectToReady(page);
    await button(page, "Parameters").click();
    await setKey(page, "observer.kappa", "0.05");
    await answers(page, "set observer.kappa=0.05", /^ok: observer\.eta/);
    await button(page, "Store").click();
    await answers(page, "store", /^ok$/);
    await button(page, "Disconnect").click();
    await connect(page);
    await tell(page, "set observer.kappa=0.04");
    await answers(page, "set observer.kappa=0.04", /observer\.eta = \d+ in the board is not that of the files/);
    await button(page, "Adopt files").click();
    await answers(page, "adopt", /^ok$/);
    await tell(page, "set observer.kappa_p=0.3");
    await answers(page, "set observer.kappa_p=0.3", /^ok: observer\./);
    await button(page, "Defaults").click();
    await answers(page, "defaults", /^ok$/);
    await tell(page, "set observer.kappa_p=0.32");
    await answers(page, "set observer.kappa_p=0.32", /^ok, and no number/);
}));

test("a recording is one that the program replays, and Replay shows it", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await button(page, "Record").click();
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    try {
        const log = join(folder, "field.log");
        await copyFile(await downloaded(page, /^Download/), log);
        const { stdout, status } = await motorsim(["replay", log]);
        assert.equal(status, 0);
        assert.match(stdout, /replayed: the outputs of all \d+ ticks and the state's hash \S+ are those recorded/);
        await button(page, "Open in Replay").click();
        await page.locator(".summary pre").waitFor();
        assert.equal(await page.locator(".summary pre").innerText(), stdout);
    } finally {
        await rm(folder, { recursive: true });
    }
}));

test("a damaged byte does not end the connection", async () => withBoard(async (page) => {
    await connectToReady(page);
    await page.evaluate(() => globalThis.fakeSerial.disturb());
    await run(page);
}));

test("a port that goes away is told in a line, and Connect works again", async () => withBoard(async (page, cable) => {
    await connectToReady(page);
    await cable.pull();
    await page.getByText("the port is gone: The device has been lost.").first().waitFor();
    await connect(page);
    await run(page);
}));

test("a person who chooses no port may choose again", async () => withBoard(async (page) => {
    await page.evaluate(() => (globalThis.fakeSerial.cancelled = true));
    await button(page, "Connect").click();
    await page.evaluate(() => (globalThis.fakeSerial.cancelled = false));
    await connect(page);
}));

test("a port that another program has gets a line", async () => withBoard(async (page) => {
    await page.evaluate(() => (globalThis.fakeSerial.busy = true));
    await button(page, "Connect").click();
    await page.getByText(/Failed to open serial port/).first().waitFor();
    await page.evaluate(() => (globalThis.fakeSerial.busy = false));
    await connect(page);
}));

test("a board is followed without a gap while another part of the page is open", async () => withBoard(async (page) => {
    await connectToReady(page);
    await run(page);
    await switchOn(page);
    await openTab(page, "Connect");
    await state(page, "RUN");
    assert.equal(await reading(page, "Gaps"), 0);
}));

const NO_ANSWER = new RegExp(`^no board answers at ${KNOWN_RATES.join(", ")} baud; check its power, its port, and that .*\\(board\\.baud\\)`);

for (const [what, makeBoard, line] of [
    ["a device of another kind", printer, NO_ANSWER],
    ["a board of another firmware", () => otherFirmware(99), /firmware is another one .*: version of the link 99, here \d/],
    ["a port at which nobody answers", frozenBoard, NO_ANSWER],
]) {
    test(`${what} gets a line`, async () => withBoard(async (page) => {
        await button(page, "Connect").click();
        await page.getByText(line).first().waitFor();
        await button(page, "Connect").waitFor();
    }, makeBoard));
}

async function frozenBoard() {
    const board = await simulatedBoard();
    board.freeze();
    return board;
}

test("the image in the emulator runs, is loaded, and has a fault with its advice", async () => withBoard(async (page, _, board) => {
    await connect(page, EMULATED_PACE);
    await page.locator(".board-name").getByText(/STM32G431 with 310 V bench inverter/).waitFor();
    await run(page);
    board.tell(`load ${LOAD_NM}`);
    await reads(page, "i_q", (amperes) => amperes > LOADED_A);
    board.tell("open phase a");
    await state(page, "FAULT");
    assert.match(await page.locator(".fault").innerText(), /^[A-Z_]+ at [\d.]+ s\s+\S.*, limit .*\s+\w.* wire/);
    assert.equal(await reading(page, "Gaps"), 0);
}, emulatedBoard));
