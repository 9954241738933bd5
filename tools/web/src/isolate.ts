// SPDX-License-Identifier: MIT
// A service worker for servers that send no headers of their own: it adds the two that isolate the page, so that the page and its
// workers may share memory. It keeps nothing.
export {}; // a module, whose `self` is its own

declare const self: ServiceWorkerGlobalScope;

const HEADERS = { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" };

async function isolated(request: Request): Promise<Response> {
    const response = await fetch(request);
    if (response.type === "opaqueredirect") { // the browser follows it, and asks again
        return response;
    }
    const headers = new Headers(response.headers);
    Object.entries(HEADERS).forEach(([name, value]) => headers.set(name, value));
    const { status, statusText } = response;
    return new Response(response.body, { status, statusText, headers });
}

self.addEventListener("install", () => void self.skipWaiting());
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", (event) => {
    const { request } = event;
    if (request.method === "GET" && new URL(request.url).origin === self.location.origin) {
        event.respondWith(isolated(request));
    }
});
