// SPDX-License-Identifier: MIT
// What a drive is asked for.

export type DriveRequest = "run" | "stop" | "clear";

export function Requests({ ask, stopTitle }: { ask(what: DriveRequest): void; stopTitle?: string }) {
    return (
        <div class="buttons" role="group" aria-label="Requests">
            <button type="button" class="main" onClick={() => ask("run")}>Start motor</button>
            <button type="button" title={stopTitle} onClick={() => ask("stop")}>Stop</button>
            <button type="button" onClick={() => ask("clear")}>Clear fault</button>
        </div>
    );
}
