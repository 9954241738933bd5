// SPDX-License-Identifier: MIT
// The form "Measure the motor" with a name plate in it.
import { button } from "./bench.mjs";

export const PLATE = {
    "Name": "out of the drawer", "Pole pairs": "7", "Largest speed [rpm]": "5000", "Continuous current, peak [A]": "15",
    "Largest current, peak [A]": "30",
};

export const plate = (page) => page.getByRole("form", { name: "Name plate" });
export const fill = (page, label, text) => plate(page).getByLabel(label).fill(text);

async function fillAll(page, fields) {
    for (const [label, text] of Object.entries(fields)) {
        await fill(page, label, text);
    }
}

// Opens the form, and fills it with PLATE but for these fields.
export async function fillPlate(page, others = {}) {
    await button(page, "Measure the motor").click();
    await fillAll(page, { ...PLATE, ...others });
}

// From the form, on the way, to what the motor will see.
export async function askToMeasure(page, fields = PLATE) {
    await fillAll(page, fields);
    await button(page, "Next").click();
    await page.getByText("The shaft must turn freely").waitFor();
}
