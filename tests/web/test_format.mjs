// SPDX-License-Identifier: MIT
// How the page writes numbers: its own source, without a browser.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { packages, ROOT } from "./bench.mjs";

const { transform } = packages("esbuild");

async function moduleOf(path) {
    const { code } = await transform(await readFile(join(ROOT, "tools/web/src", path), "utf8"), { loader: "ts" });
    return import(`data:text/javascript,${encodeURIComponent(code)}`);
}

const { shown, significant } = await moduleOf("parts/format.ts");

for (const [what, cases] of Object.entries({
    "noise of rounding is 0, without a sign": [
        [-2.9487e-60, "rpm", "0"], [-0.004, "rpm", "0"], [-0, "rpm", "0"], [4e-5, "A", "0"], [-1e-13, "", "0"], [3e-17, "H", "0"],
    ],
    "a quantity has the decimals that are worth reading": [
        [899.7512, "rpm", "899.75"], [-0.0026689, "A", "-0.0027"], [2.091823, "N·m", "2.0918"], [-28.27634, "°", "-28.28"],
    ],
    "a large number has five digits": [[123456.7, "rpm", "123460"], [207.12345, "rad", "207.12"]],
    "small parameters keep their digits": [[0.00018153, "H", "0.00018153"], [1.2345678e-7, "kg·m²", "1.2346e-7"]],
    "what is not known is a dash": [[null, "rpm", "–"], [undefined, "", "–"], [NaN, "A", "–"]],
})) {
    test(what, () => cases.forEach(([value, unit, text]) => assert.equal(shown(value, unit), text)));
}

test("more digits are as asked for, and noise is 0 there too", () => {
    assert.equal(significant(310.03412, 6), "310.034");
    assert.equal(significant(-2.9e-60, 6), "0");
});
