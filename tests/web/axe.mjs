// SPDX-License-Identifier: MIT
// What axe-core finds in a page.
import { readFile } from "node:fs/promises";
import { packages, WINDOWS } from "./bench.mjs";

const [PHONE, TABLET, LAPTOP, DESKTOP] = WINDOWS;
// Places are the same in each theme: a width in one of them is enough. Colours are the same at each width, and contrast is dear.
const LOOKS = [
    { colorScheme: "light", size: LAPTOP, hasContrast: true },
    { colorScheme: "light", size: PHONE, hasContrast: false },
    { colorScheme: "dark", size: DESKTOP, hasContrast: true },
    { colorScheme: "dark", size: TABLET, hasContrast: false },
];

// At four widths, light and dark.
export async function violations(page) {
    await page.addScriptTag({ content: await readFile(packages.resolve("axe-core/axe.min.js"), "utf8") });
    const all = [];
    for (const { colorScheme, size, hasContrast } of LOOKS) {
        await page.emulateMedia({ colorScheme });
        await page.setViewportSize(size);
        const options = { resultTypes: ["violations"], rules: { "color-contrast": { enabled: hasContrast } } };
        const { violations: found } = await page.evaluate((given) => globalThis.axe.run(given), options);
        all.push(...found.map(({ id, nodes }) => `${size.width}: ${id}: ${nodes.map(({ html }) => html).join(" ")}`));
    }
    return all;
}
