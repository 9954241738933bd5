// SPDX-License-Identifier: MIT
// A board in the page's head, whichever part of the bench is open: how it stands, and the way to stop it.
import { useEffect } from "preact/hooks";
import { useRefresh } from "../parts/use_refresh.ts";
import { MotorAlarms } from "./alarms.tsx";
import type { Board } from "./board.ts";
import { useBoard } from "./use_board.ts";

// A key that is held down repeats itself: one stop is enough.
function onKey(board: Board, event: KeyboardEvent): void {
    if (event.key === "Escape" && !event.repeat) {
        void board.talk.stop();
    }
}

// The browser asks a person before the page is gone, and the motor with nobody who watches it.
function onUnload(board: Board, event: BeforeUnloadEvent): void {
    if (board.phase === "following" && board.mayRun) {
        event.preventDefault();
    }
}

function useGuards(board: Board): void {
    useEffect(() => {
        const gone = new AbortController();
        document.addEventListener("keydown", (event) => onKey(board, event), { signal: gone.signal });
        window.addEventListener("beforeunload", (event) => onUnload(board, event), { signal: gone.signal });
        return () => gone.abort();
    }, [board]);
}

function Now({ board }: { board: Board }) {
    useRefresh();
    const { block, isNow } = board;
    const state = isNow ? block?.fault?.name ?? block?.state : "not followed";
    return (
        <>
            <span role="status">{`Board: ${state}`}</span>
            <button type="button" onClick={() => void board.talk.stop()}>Stop the board</button>
        </>
    );
}

// `isShown`: not where the tab has its own. What has to be known of a board that was lost stands here too.
export function BoardLine({ isShown }: { isShown: boolean }) {
    const board = useBoard();
    useGuards(board);
    const isThere = board.phase !== "away";
    if (!isShown || (!isThere && board.head === undefined)) {
        return null;
    }
    return (
        <div class="board-line buttons">
            {isThere && <Now board={board} />}
            <MotorAlarms board={board} />
        </div>
    );
}
