// SPDX-License-Identifier: MIT
// Signals that the page shows beside the scope: as figures, and in the drawing of the motor.
import type { ReadSignal } from "../parts/readings.tsx";

export const READINGS: ReadSignal[] = [
    { label: "Speed", name: "speed_rpm", unit: "rpm" },
    { label: "Speed, estimated", name: "speed_estimated_rpm", unit: "rpm" },
    { label: "Torque", name: "torque_nm", unit: "N·m" },
    { label: "i_q", name: "i_q_a", unit: "A" },
    { label: "i_d", name: "i_d_a", unit: "A" },
    { label: "v_q", name: "v_q_v", unit: "V" },
    { label: "v_d", name: "v_d_v", unit: "V" },
    { label: "Bus", name: "bus_v", unit: "V" },
    { label: "Rotor position", name: "position_rad", unit: "rad" },
];
const DRAWN = ["angle_el_deg", "angle_estimated_el_deg", "angle_error_el_deg"];

export const SHOWN = [...READINGS.map(({ name }) => name), ...DRAWN];
