// SPDX-License-Identifier: MIT
// How a board stands now: its fault, its state, its figures and those of the line.
import type { LiveBlock } from "../core/protocol.ts";
import { FaultCard } from "../parts/fault_card.tsx";
import { shown } from "../parts/format.ts";
import { type Reading, Readings } from "../parts/readings.tsx";
import { StateMachine } from "../parts/state_machine.tsx";
import { useRefresh } from "../parts/use_refresh.ts";
import type { Board } from "./board.ts";

const READINGS: [string, string, string][] = [
    ["Speed, estimated", "speed_estimated_rpm", "rpm"],
    ["Speed command", "speed_command_rpm", "rpm"],
    ["Position", "position_estimated_rad", "rad"],
    ["i_q", "drive.signals.current.q", "A"],
    ["i_d", "drive.signals.current.d", "A"],
    ["Bus", "drive.signals.bus", "V"],
];
const BYTES_PER_KB = 1000;

function readingsOf({ values }: LiveBlock): Reading[] {
    return READINGS.map(([label, name, unit]) => ({ label, text: `${shown(values[name])} ${unit}` }));
}

function lineOf({ health, in_step: inStep, is_run_wanted: isRunWanted }: LiveBlock, bytesPerS: number): Reading[] {
    return [
        { label: "In step", text: inStep ? "yes" : "no", isBad: !inStep },
        { label: "Asked to run", text: isRunWanted ? "yes" : "no" },
        { label: "Load of the processor", text: `${shown(health.load_pct)} %` },
        { label: "Late ticks", text: String(health.late_ticks), isBad: health.late_ticks > 0 },
        { label: "Gaps", text: String(health.gaps) },
        { label: "Damaged frames", text: String(health.broken) },
        { label: "Comes in", text: `${(bytesPerS / BYTES_PER_KB).toFixed(1)} kB/s` },
    ];
}

// What must not be missed.
export function Alarms({ board }: { board: Board }) {
    useRefresh();
    const { block } = board;
    return (
        <>
            <div role="alert">
                {block?.health.tick_lost === true && <p class="fault"><strong>THE CONTROL TICK STAYS AWAY</strong></p>}
            </div>
            <FaultCard fault={block?.fault ?? null} />
        </>
    );
}

export function BoardNow({ board }: { board: Board }) {
    useRefresh();
    const { block, head } = board;
    if (block === undefined || head === undefined) {
        return null;
    }
    const { no_stream: noStream } = block.health;
    const isNow = board.phase === "following";
    return (
        <>
            <StateMachine moves={head.moves} state={block.state === "" ? "not known yet" : block.state} />
            <Readings caption={`${isNow ? "Now" : "Last"}, t = ${block.time_s.toFixed(3)} s`} rows={readingsOf(block)} />
            <div class="line">
                <Readings caption={isNow ? "Line" : "Line, as it was"} rows={lineOf(block, board.rate.perS)} />
                {noStream !== "" && <p class="problem" role="status">{`The board sends no ticks: ${noStream}`}</p>}
            </div>
        </>
    );
}
