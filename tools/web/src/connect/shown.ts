// SPDX-License-Identifier: MIT
// Signals of a board that the page shows beside the scopes.
import type { LiveBlock } from "../core/protocol.ts";
import type { ReadSignal } from "../parts/readings.tsx";

const POSITION = "position_estimated_rad";
const DEG_PER_RAD = 180 / Math.PI;

export const READINGS: ReadSignal[] = [
    { label: "Speed, estimated", name: "speed_estimated_rpm", unit: "rpm" },
    { label: "Speed command", name: "speed_command_rpm", unit: "rpm" },
    { label: "Position", name: POSITION, unit: "°", factor: DEG_PER_RAD },
    { label: "i_q", name: "i_q_measured_a", unit: "A" },
    { label: "i_d", name: "i_d_measured_a", unit: "A" },
    { label: "Bus", name: "drive.bus", unit: "V" },
];

export const SHOWN = READINGS.map(({ name }) => name);

// Null: not known.
export function rotorDeg({ in_step: inStep, values }: LiveBlock): number | null {
    const rad = values[POSITION] ?? null;
    return inStep && rad !== null ? rad * DEG_PER_RAD : null;
}
