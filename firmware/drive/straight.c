/* SPDX-License-Identifier: MIT */
#include "straight.h"

#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "voltage_drive.h"

INLINES_ALL void straight_estimate(drive_t *drive)
{
    estimate_step(drive, true);
}

INLINES_ALL void straight_control(drive_t *drive, drive_out_t *out)
{
    const frame_t frame = frame_of_rotor(drive);

    if (drive->voltage_drive.active) {
        voltage_drive_step(drive);
    } else {
        frame_control_current(drive, &frame);
    }
    frame_modulate(drive, &frame, &out->compare);
    out->gate_enable = true;
    estimate_advance(drive, true);
}
