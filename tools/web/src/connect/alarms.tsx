// SPDX-License-Identifier: MIT
// What a person must not miss of a board, or of one that was lost.
import { FaultCard } from "../parts/fault_card.tsx";
import { useRefresh } from "../parts/use_refresh.ts";
import type { Board } from "./board.ts";

function Alarm({ text }: { text: string }) {
    return <p class="alarm"><strong>{text}</strong></p>;
}

function stopText({ talk: { stopping } }: Board): string {
    if (stopping.isPending) {
        return "Stop: asked…";
    }
    return stopping.problem === "" ? "" : `THE BOARD HAS NOT CONFIRMED THE STOP: ${stopping.problem}`;
}

// Whether the motor stands still is asked for in each part of the bench.
export function MotorAlarms({ board }: { board: Board }) {
    const stop = stopText(board);
    return (
        <div role="alert">
            {stop !== "" && <Alarm text={stop} />}
            {board.danger !== "" && <Alarm text={board.danger} />}
        </div>
    );
}

export function Alarms({ board }: { board: Board }) {
    useRefresh();
    const { block } = board;
    const departures = block?.health.departures ?? 0;
    return (
        <>
            <MotorAlarms board={board} />
            <div role="alert">
                {board.phase === "following" && block?.health.tick_lost === true && (
                    <Alarm text="The control interrupt does not run. The board may not control the motor: switch the power off." />
                )}
                {departures > 0 && (
                    <Alarm
                        text={`THE BOARD DEPARTS from the same firmware on the same inputs: ${departures} times. See the dialogue.`}
                    />
                )}
            </div>
            <FaultCard fault={block?.fault ?? null} isPast={!board.isNow} />
        </>
    );
}
