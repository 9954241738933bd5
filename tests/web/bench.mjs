// SPDX-License-Identifier: MIT
// What the browser's tests share: the page on a server of its own, Debian's Chromium, and the native program beside it.
// The environment says where they are: NF_WEB (the page), NF_PYTHON, NF_MOTORSIM.
import { execFile, spawn } from "node:child_process";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

export const ROOT = join(dirname(fileURLToPath(import.meta.url)), "../..");
// The packages of the page, which lie beside it.
export const packages = createRequire(join(ROOT, "tools/web/package.json"));
const { chromium } = packages("playwright-core");

const CHROMIUM = "/usr/bin/chromium";
// A phone, a tablet, a laptop and a desktop.
export const WINDOWS = [[390, 844], [768, 1024], [1280, 720], [1920, 1080]].map(([width, height]) => ({ width, height }));
const WINDOW = WINDOWS[2];
export const LOAD_MS = Number(process.env.NF_WAIT_MS ?? 60_000); // on a machine that does other things too

export function setting(name) {
    const value = process.env[name];
    if (value === undefined) {
        throw new Error(`${name} is not set in the environment; allowed: what tests/web/CMakeLists.txt gives it`);
    }
    return value;
}

// `isPlain`: with a server that sends files alone, and none of the headers that isolate the page.
async function serve(isPlain) {
    const folder = setting("NF_WEB");
    const args = isPlain
        ? ["-u", "-m", "http.server", "0", "--bind", "127.0.0.1", "--directory", folder]
        : [join(ROOT, "tools/web/serve.py"), folder, "--port", "0"];
    const server = spawn(setting("NF_PYTHON"), args, { stdio: ["ignore", "pipe", isPlain ? "ignore" : "inherit"] });
    for await (const line of createInterface({ input: server.stdout })) {
        return { address: /http:[^\s)]+/.exec(line)[0], stop: () => server.kill("SIGINT") };
    }
    throw new Error("the server of the page has ended before it said its address");
}

// Calls test(page, address) with an open page. A request to another place, or an error in the page, fails it.
// `options` are the browser's, and `init`, a script that comes before the page's own, as Playwright's addInitScript takes it.
export async function withPage(test, { init, isPlain = false, ...options } = {}) {
    const server = await serve(isPlain);
    const browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox"] });
    const strange = [];
    try {
        const context = await browser.newContext({ viewport: WINDOW, acceptDownloads: true, ...options });
        const page = await context.newPage();
        await page.addInitScript(init ?? (() => undefined));
        page.setDefaultTimeout(LOAD_MS);
        page.on("request", (request) => {
            if (!/^(data|blob):/.test(request.url()) && !request.url().startsWith(server.address)) {
                strange.push(`request to ${request.url()}`);
            }
        });
        page.on("pageerror", (error) => strange.push(`error in the page: ${error.message}`));
        await page.goto(server.address);
        await test(page, server.address);
    } finally {
        await browser.close();
        server.stop();
    }
    if (strange.length > 0) {
        throw new Error(strange.join("\n"));
    }
}

// The newest run has come to its end and is shown.
export async function settled(page) {
    await page.locator("section[aria-label=Results][aria-busy=false]").waitFor();
}

// Reads until it is good: a page shows what has happened a moment later.
export async function until(read, isGood) {
    const end = Date.now() + LOAD_MS;
    let found = await read();
    while (!isGood(found)) {
        if (Date.now() > end) {
            throw new Error(`${JSON.stringify(found)} is found, and stays so`);
        }
        await new Promise((resolve) => setTimeout(resolve, 20));
        found = await read();
    }
    return found;
}

// Opens a file in the editor; its first line with this text.
export async function openFile(page, path, text) {
    await page.getByRole("button", { name: "Files" }).click();
    await page.getByRole("button", { name: path }).click();
    const line = page.locator(".cm-line").filter({ hasText: text }).first();
    await line.waitFor();
    return line;
}

export async function replaceLine(page, line, text) {
    await line.click();
    await page.keyboard.press("Home");
    await page.keyboard.press("Shift+End");
    await page.keyboard.type(text);
}

// The native program: {stdout, stderr, status}.
export function motorsim(args, cwd = ROOT) {
    return new Promise((resolve) => {
        const limits = { cwd, maxBuffer: 1 << 30 };
        execFile(setting("NF_MOTORSIM"), args, limits, (error, stdout, stderr) => {
            resolve({ stdout, stderr, status: error?.code ?? 0 });
        });
    });
}

// A request to a worker of its own, as the page makes them. Of a value that is an object the fields `keep`; with `cancel` it
// is stopped when it first reports progress.
export function ask(page, name, given, { keep, cancel } = {}) {
    return page.evaluate(([name, given, keep, cancel]) => new Promise((resolve) => {
        globalThis.testWorker ??= new Worker("worker.js", { type: "module" });
        globalThis.testWorker.onmessage = ({ data }) => {
            if (!("progress" in data)) {
                const { value } = data;
                resolve(keep && value ? { value: Object.fromEntries(keep.map((key) => [key, value[key]])) } : data);
            } else if (cancel) {
                globalThis.testWorker.postMessage({ cancel: 1 });
            }
        };
        globalThis.testWorker.postMessage({ id: 1, name, given });
    }), [name, given, keep, cancel]);
}

export const button = (page, name) => page.getByRole("button", { name, exact: true });

// Into a field, as a person does.
export async function type(page, label, text) {
    await page.getByLabel(label, { exact: true }).fill(text);
    await page.keyboard.press("Enter");
}

// Until the drive is in it.
export function state(page, name) {
    return page.getByText(`State: ${name}`, { exact: true }).waitFor();
}

export async function reading(page, name) {
    const text = await page.getByRole("row", { name: new RegExp(`^${name} `) }).locator("td").innerText();
    return Number(text.split(" ")[0]);
}

// Until a reading is so.
export function reads(page, name, holds) {
    return until(() => reading(page, name), holds);
}

// What a button gives as a file: the path of it.
export async function downloaded(page, name) {
    const waiting = page.waitForEvent("download");
    await page.getByRole("button", { name }).click();
    return (await waiting).path();
}

// Opens another part of the bench.
export async function openTab(page, name) {
    await page.getByRole("tab", { name, exact: true }).click();
}

// A machine that is switched on, in the tab Play.
export async function switchOn(page) {
    await openTab(page, "Play");
    await page.getByRole("button", { name: "Switch the machine on" }).click();
    await page.getByText("State: READY", { exact: true }).waitFor();
}

// A recording of a phase that opens: the path of its log. The caller removes the folder.
export async function recordedFault(folder) {
    const path = join(folder, "field.log");
    await motorsim(["run", "s1_robust", "--set", 'scenario.fault=[{time_s=0.3, what="phase_a_open"}]', "--record", path]);
    return path;
}
