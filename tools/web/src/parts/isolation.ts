// SPDX-License-Identifier: MIT
// The service worker that isolates the page where the server does not; the page has to be loaded once more then.
import { canShare } from "../core/shared_line.ts";

const workers: ServiceWorkerContainer | undefined = "serviceWorker" in navigator ? navigator.serviceWorker : undefined;
// When the page was loaded: a worker that comes later takes the page over, but its headers count from the next loading on.
const wasServed = (workers?.controller ?? null) !== null;

// Not where the page comes from another machine without TLS: browsers have no service workers there.
export function isolateLater(): void {
    if (!canShare()) {
        workers?.register("./isolate.js").catch((error: Error) => console.warn(`isolate.js: ${error.message}`));
    }
}

// Whether loading the page once more can help.
export function canIsolateLater(): boolean {
    return workers !== undefined && !wasServed;
}
