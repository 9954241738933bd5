// SPDX-License-Identifier: MIT
// Makes the pictures of docs/bench_in_the_browser.md: screenshots.mjs FOLDER. The environment is that of the tests (bench.mjs).
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { button, openTab, reads, recordedFault, settled, state, switchOn, type, withPage } from "./bench.mjs";
import { simulatedBoard } from "./board.mjs";
import { Cable, FAKE_SERIAL } from "./cable.mjs";
import { connect, openConnect } from "./connected.mjs";

const [folder] = process.argv.slice(2);
if (folder === undefined) {
    console.error("screenshots.mjs: names no folder; usage: screenshots.mjs FOLDER");
    process.exit(2);
}

const near = (target, share) => (value) => Math.abs(value - target) < Math.abs(target) * share;

async function keep(page, name) {
    await page.mouse.move(0, 0);
    await page.screenshot({ path: join(folder, `bench_${name}.png`) });
    console.log(name);
}

async function run(page) {
    await settled(page);
    await keep(page, "run");
}

async function playAndStep(page) {
    await settled(page);
    await switchOn(page);
    await button(page, "Start motor").click();
    await type(page, "Speed [rpm]", "900");
    await state(page, "RUN");
    await reads(page, "Speed", near(900, 0.05));
    await type(page, "Load torque [N·m]", "2");
    await reads(page, "Torque", near(2, 0.1));
    await button(page, "Open phase a").click();
    await state(page, "FAULT");
    await keep(page, "play");
    await button(page, "Step through this").click();
    await button(page, "To the tick before the fault").click();
    await page.getByText(/^Stages of tick/).waitFor();
    await keep(page, "step");
}

async function replay(page) {
    const recordings = await mkdtemp(join(tmpdir(), "neurofoc-"));
    await openTab(page, "Replay");
    await page.getByLabel("Or choose a file").setInputFiles(await recordedFault(recordings));
    await page.getByRole("button", { name: /^Step from tick/ }).waitFor();
    await keep(page, "replay");
    await rm(recordings, { recursive: true });
}

async function followed(page, board) {
    const cable = await Cable.of(page, board);
    await openConnect(page);
    await connect(page);
    await state(page, "RUN"); // its script runs it
    await button(page, "Parameters").click();
    await type(page, "Speed [rpm]", "600");
    await reads(page, "Speed, estimated", near(600, 0.05));
    await type(page, "Speed [rpm]", "1200");
    await reads(page, "Speed, estimated", near(1200, 0.05));
    await keep(page, "connect");
    await cable.close();
}

await withPage(run);
await withPage(playAndStep, { colorScheme: "dark" });
await withPage(replay);
const board = await simulatedBoard();
try {
    await withPage((page) => followed(page, board), { init: FAKE_SERIAL });
} finally {
    board.end();
}
