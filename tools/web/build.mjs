// SPDX-License-Identifier: MIT
// Makes the page: build.mjs WASM_FOLDER OUT_FOLDER. All of it lies in OUT_FOLDER then, and asks nothing of another place.
import { build } from "esbuild";
import { cp, mkdir, rm } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [wasmFolder, out] = process.argv.slice(2);
if (wasmFolder === undefined || out === undefined) {
    console.error("build.mjs: names no folders; usage: build.mjs WASM_FOLDER OUT_FOLDER");
    process.exit(2);
}
const source = join(dirname(fileURLToPath(import.meta.url)), "src");

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const common = { outdir: out, bundle: true, minify: true, target: "es2022", logLevel: "warning" };
await build({
    ...common,
    entryPoints: { main: join(source, "main.tsx"), worker: join(source, "core/worker.ts") },
    format: "esm",
    splitting: true,
    jsx: "automatic",
    jsxImportSource: "preact",
    legalComments: "eof",
});
await build({ ...common, entryPoints: { isolate: join(source, "isolate.ts") }, format: "iife" });
await build({ ...common, entryPoints: { main: join(source, "main.css") } });
await cp(join(source, "index.html"), join(out, "index.html"));
for (const name of ["bench.mjs", "bench.wasm"]) {
    await cp(join(wasmFolder, name), join(out, name));
}
