// SPDX-License-Identifier: MIT
// How a person leaves a board. Of a motor that may run it has to be said whether it is to run on.
import { useRefresh } from "../parts/use_refresh.ts";
import type { Board } from "./board.ts";

export function Leave({ board }: { board: Board }) {
    useRefresh();
    const leave = (): void => void board.disconnect();
    if (!board.mayRun) {
        return <button type="button" onClick={leave}>Disconnect</button>;
    }
    return (
        <div class="buttons" role="group" aria-label="Disconnect">
            <button type="button" onClick={() => void board.stopAndDisconnect()}>Stop and disconnect</button>
            <button type="button" onClick={leave}>Leave it running</button>
        </div>
    );
}
