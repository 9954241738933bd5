// SPDX-License-Identifier: MIT
// How a board stands now, or stood when it was heard last: its state, its figures and those of the line.
import type { BoardCommand, LiveBlock } from "../core/protocol.ts";
import { shown } from "../parts/format.ts";
import { type Reading, Readings, readingsOf } from "../parts/readings.tsx";
import { StateMachine } from "../parts/state_machine.tsx";
import { useRefresh } from "../parts/use_refresh.ts";
import type { Board } from "./board.ts";
import { READINGS } from "./shown.ts";

const BYTES_PER_KB = 1000;

function askedToRun(command: BoardCommand | null): string {
    if (command === null) {
        return "not known";
    }
    return command.run ? "yes" : "no";
}

function lineOf({ health, in_step: inStep, command }: LiveBlock, bytesPerS: number): Reading[] {
    return [
        { label: "Values verified", text: inStep ? "yes" : "no", isBad: !inStep },
        { label: "Hashes compared", text: String(health.hashes) },
        { label: "Departures", text: String(health.departures), isBad: health.departures > 0 },
        { label: "Asked to run", text: askedToRun(command) },
        { label: "Commanded by", text: health.source },
        { label: "Input", text: health.input_lost === "" ? "–" : health.input_lost, isBad: health.input_lost !== "" },
        { label: "Last reset", text: health.reset },
        { label: "Load of the processor", text: `${shown(health.load_pct)} %` },
        { label: "Late ticks", text: String(health.late_ticks), isBad: health.late_ticks > 0 },
        { label: "Gaps", text: String(health.gaps) },
        { label: "Damaged frames", text: String(health.broken) },
        { label: "Received", text: `${(bytesPerS / BYTES_PER_KB).toFixed(1)} kB/s` },
    ];
}

export function BoardNow({ board }: { board: Board }) {
    useRefresh();
    const { block, head, isNow } = board;
    if (block === undefined || head === undefined) {
        return null;
    }
    const { no_stream: noStream } = block.health;
    const isKnown = block.state !== "";
    const isFollowed = board.phase === "following";
    return (
        <>
            <StateMachine moves={head.moves} state={isKnown ? block.state : "not known yet"} isPast={isKnown && !isNow} />
            <div class={isNow ? "figures" : "figures past"}>
                <Readings
                    caption={`${isNow ? "Now" : "Last known"}, t = ${block.time_s.toFixed(3)} s`}
                    rows={readingsOf(READINGS, block.values)}
                />
            </div>
            <div class={isFollowed ? "figures" : "figures past"}>
                <Readings caption={isFollowed ? "Line" : "Line, as it was"} rows={lineOf(block, board.rate.perS)} />
                {noStream !== "" && <p class="problem" role="status">{`The board sends no ticks: ${noStream}`}</p>}
            </div>
        </>
    );
}
