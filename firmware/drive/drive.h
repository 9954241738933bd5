/* SPDX-License-Identifier: MIT */
/*
 * The drive: one pure control step from an input frame to an output frame.
 *
 *     drive_step(&drive, &in, &out)
 *
 * reads its state and one frame of raw measurements and command. It writes its state and one frame
 * of compare values. It has no clock, no hardware, no globals and no allocation. The same inputs
 * give the same outputs on every machine. drive_t is a plain value: to copy it is to take a
 * snapshot.
 *
 * Timing. The frame of tick k is sampled at t_k, the start of PWM period k. Its compare values act
 * from t_k+1 to t_k+2; gate_enable acts at once.
 *
 * States
 *     INIT → OFFSET_CAL → READY → FLYING_START → ALIGN → HOLD ⇄ IF_RAMP → HANDOVER → RUN → HOLD
 *     FLYING_START → RUN when the rotor turns already
 *     HANDOVER → FLYING_START when the hand-over fails
 *     any but INIT, OFFSET_CAL, FAULT → READY without DRIVE_REQUEST_RUN
 *     any → FAULT, latched, gates off in the same tick
 *     FAULT → OFFSET_CAL on DRIVE_REQUEST_CLEAR without DRIVE_REQUEST_RUN
 *
 * In RUN the currents are controlled in the frame of the rotor, whose angle observer or sensor
 * give. In ALIGN, HOLD, IF_RAMP and HANDOVER the drive imposes a current vector and controls it in
 * the frame of that vector. When the configuration has no start-up (startup.current_hold is 0),
 * READY goes to RUN: the rotor is then taken to be at angle 0, or at the angle of the sensor.
 */
#ifndef DRIVE_H
#define DRIVE_H

#include "io.h"
#include "schedule.h"
#include "state.h"

#include <stdint.h>

/*
 * Bring the drive to INIT with this configuration, which must outlive the drive. Call before the
 * first tick, never from the interrupt. Returns NULL when the configuration is accepted. Otherwise
 * it returns the name of the field that config_check refuses, or "crc" when the checksum does not
 * match; the drive must not be stepped then.
 */
const char *drive_init(drive_t *drive, const drive_cfg_t *cfg);

/*
 * The winding is as warm as this: Q24, 1 is the steady heat of the continuous current,
 * 0…DERATING_HEAT_MAX_Q24. Call between drive_init() and the first tick.
 */
void drive_warm(drive_t *drive, int32_t heat_q24);

/*
 * From the next drive_step() on the drive runs with `cfg`, which must outlive the drive or the next
 * change. It is one that config_check() accepts, with its checksum.
 *
 * Of what config_change_refused() allows the drive keeps its state. What was measured of the motor
 * stays as a ratio to the values of the new configuration, and so does the voltage of the current
 * control: what the model gives otherwise goes to the integrals. A voltage drive goes back to
 * current control. A measurement of a start that is under way begins again. What a slot of the slow
 * schedule computes follows in its slot, within a slow period.
 *
 * If the checksum is equal, only the pointer changes.
 *
 * Of anything else the drive begins anew: it opens the gates, goes to INIT and calibrates; nothing
 * that was measured is known. So the caller asks config_change_refused() first, and goes on at rest
 * only. A latched fault stays.
 *
 * Total and pure: a replay with the same change in front of the same frame repeats it bit for bit.
 * Context: control interrupt, right before drive_step().
 */
void drive_change(drive_t *drive, const drive_cfg_t *cfg);

/*
 * Whether the next tick is the one of a slow period in which the drive reads the temperature.
 * control_isr() takes the command then, and the recorder looks for a change of both. So a command
 * waits for up to a slow period.
 */
static inline bool drive_reads_slow_inputs(const drive_t *drive)
{
    return drive->slow_count == ((uint32_t)SLOT_CHECKS + 1U);
}

/* The same after drive_step(), of the tick that has ended. */
static inline bool drive_has_read_slow_inputs(const drive_t *drive)
{
    return drive->slow_count == (uint32_t)SLOT_CHECKS;
}

/* One control tick. Total: every input frame is allowed. Context: control interrupt only. */
void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out);

#endif
