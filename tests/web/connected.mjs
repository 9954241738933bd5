// SPDX-License-Identifier: MIT
// The tab Connect with a board at it.
import { button, openTab, reads, settled, state, type, withPage } from "./bench.mjs";
import { SIMULATED_PACE, simulatedBoard } from "./board.mjs";
import { Cable, FAKE_SERIAL } from "./cable.mjs";

export const BAUD = 460800; // board.baud of both boards
export const SPEED_RPM = 600;
const SPEED_NEAR_RPM = 30; // 5 %

export async function openConnect(page) {
    await settled(page);
    await openTab(page, "Connect");
}

// Calls test(page, cable, board) with the tab open and the board at the cable.
export async function withBoard(test, makeBoard = simulatedBoard, options = {}) {
    const board = await makeBoard();
    try {
        await withPage(async (page) => {
            const cable = await Cable.of(page, board);
            try {
                await openConnect(page);
                await test(page, cable, board);
            } finally {
                await cable.close();
            }
        }, { init: FAKE_SERIAL, ...options });
    } finally {
        board.end();
    }
}

// As a person connects: the board says who it is, and its signals come.
export async function connect(page, pace = SIMULATED_PACE) {
    await type(page, "Baud rate [baud]", String(BAUD));
    await type(page, "Board's time ×", String(pace));
    await button(page, "Connect").click();
    await page.locator(".board-name").getByText(/^neurofoc: motor A \(paper A, table 1\), /).waitFor();
    await page.getByText(/^State: [A-Z]/).waitFor();
}

// The script of a simulated board commands it until somebody else does.
export async function connectToReady(page) {
    await connect(page);
    await button(page, "Stop").click();
    await state(page, "READY");
}

export async function run(page, rpm = SPEED_RPM) {
    await type(page, "Speed [rpm]", String(rpm));
    await button(page, "Start motor").click();
    await state(page, "RUN");
    await reads(page, "Speed, estimated", (now) => Math.abs(now - rpm) < SPEED_NEAR_RPM);
}

export async function setKey(page, key, value) {
    await type(page, `New value of ${key}`, value);
}

// Of the table of parameters.
export function valueOf(page, key) {
    const row = page.getByRole("row").filter({ has: page.getByRole("rowheader", { name: key, exact: true }) });
    return row.locator("td").first().innerText();
}
