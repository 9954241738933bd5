// SPDX-License-Identifier: MIT
// What of a board is drawn first, of its recording too.

export const FIRST_PANELS = [
    ["speed_command_rpm", "speed_estimated_rpm"],
    ["drive.signals.current.q", "drive.signals.current.d"],
    ["drive.signals.bus"],
];
