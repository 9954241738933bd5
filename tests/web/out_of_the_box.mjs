// SPDX-License-Identifier: MIT
// The tab Connect with a board out of the box, whose motor nobody knows.
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { button, state, type } from "./bench.mjs";
import { boardOutOfTheBox, SIMULATED_PACE } from "./board.mjs";
import { withBoard } from "./connected.mjs";

// Of more than the example of the image.
const MACHINE = {
    resistance_scale: 1.6, inductance_scale: 1.5, flux_scale: 0.7, inertia_scale: 2, coulomb_friction_nm: 0.003,
};

async function withFolder(act) {
    const folder = await mkdtemp(join(tmpdir(), "neurofoc-"));
    try {
        await act(folder);
    } finally {
        await rm(folder, { recursive: true });
    }
}

// The board's time is no matter of a person.
export function atPace(page) {
    return type(page, "Board's time ×", String(SIMULATED_PACE));
}

// Calls test(page, hands) with a board out of the box at the cable; `hands` are what a person has beside the page.
export function outOfTheBox(test) {
    return withFolder(async (folder) => {
        const boards = [];
        // With what is stored under this name.
        const makeBoard = async (name) => {
            boards.push(await boardOutOfTheBox(MACHINE, join(folder, `${name}.flash`)));
            return boards.at(-1);
        };
        try {
            await withBoard(async (page, cable, board) => {
                await atPace(page);
                await test(page, { cable, board, makeBoard, folder });
            }, () => makeBoard("first"));
        } finally {
            boards.forEach((board) => board.end());
        }
    });
}

export async function connectTo(page, name, drive = "READY") {
    await button(page, "Connect").click();
    await page.locator(".board-name").getByText(name).waitFor();
    await state(page, drive);
}
