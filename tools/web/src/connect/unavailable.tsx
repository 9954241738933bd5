// SPDX-License-Identifier: MIT
// Why a board cannot be connected here, and what to do.
import type { ComponentChildren } from "preact";
import { canShare } from "../core/shared_line.ts";
import { canIsolateLater } from "../parts/isolation.ts";
import { serialOf } from "./web_serial.ts";

function NoSerial() {
    return (
        <>
            <h2>This browser has no Web Serial</h2>
            <p>
                A page needs it to talk to a board. Browsers made of Chromium have it, such as Chrome and Edge, when the page comes
                from this machine or over https.
            </p>
            <p>The native program does the same:</p>
            <pre>build/host/motorsim live /dev/ttyACM0</pre>
        </>
    );
}

function NotIsolated() {
    return (
        <>
            <h2>The page has to be loaded once more</h2>
            <p>
                The page and its simulator share memory for what comes from the board. The browser lets them only when nothing of
                another place can be in the page. Load the page again to allow it.
            </p>
            <button type="button" class="main" onClick={() => location.reload()}>Load the page once more</button>
            <p>
                {canIsolateLater() ? "Where that does not help" : "Loading it again did not help"}
                {": the server has to send two headers with each file, over https or from this machine:"}
            </p>
            <pre>{"Cross-Origin-Opener-Policy: same-origin\nCross-Origin-Embedder-Policy: require-corp"}</pre>
        </>
    );
}

// What is in it, or why it cannot be.
export function WhereAvailable({ children }: { children: ComponentChildren }) {
    const hasSerial = serialOf(navigator) !== undefined;
    if (hasSerial && canShare()) {
        return <>{children}</>;
    }
    return <section class="explained" aria-label="Why no board">{hasSerial ? <NotIsolated /> : <NoSerial />}</section>;
}
