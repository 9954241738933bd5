// SPDX-License-Identifier: MIT
// What of a board is drawn first, of its recording too.

export const FIRST_PANELS = [
    ["speed_command_rpm", "speed_estimated_rpm"],
    ["i_q_measured_a", "i_d_measured_a"],
    ["drive.bus"],
];
