/* SPDX-License-Identifier: MIT */
/*
 * The drive: one pure control step from an input frame to an output frame.
 *
 *     drive_step(&drive, &in, &out)
 *
 * reads its state and one frame of raw measurements and command. It writes its state and one frame
 * of compare values. It has no clock, no hardware, no globals and no allocation. The same inputs
 * give the same outputs on every machine. drive_t is a plain value: a copy of it is a snapshot.
 *
 * Timing. The frame of tick k is sampled at t_k, the start of PWM period k. Its compare values act
 * from t_k+1 to t_k+2; gate_enable acts at once.
 *
 * States
 *     INIT → OFFSET_CAL → READY → FLYING_START → ALIGN → HOLD ⇄ IF_RAMP → HANDOVER → RUN → HOLD
 *     FLYING_START → RUN when the rotor turns already, → IF_RAMP when it turns slowly
 *     HOLD → ALIGN when R and L have not been measured yet
 *     ALIGN, HOLD, IF_RAMP, HANDOVER → FLYING_START when the start fails or the rotor is lost
 *     READY → PROBE on DRIVE_REQUEST_PROBE without DRIVE_REQUEST_RUN
 *     PROBE → READY without DRIVE_REQUEST_PROBE
 *     any but INIT, OFFSET_CAL, PROBE, FAULT → READY without DRIVE_REQUEST_RUN
 *     any → FAULT, latched, gates off in the same tick
 *     FAULT → OFFSET_CAL on DRIVE_REQUEST_CLEAR without DRIVE_REQUEST_RUN
 *
 * In RUN the currents are controlled in the frame of the rotor. The observer or the sensor gives
 * the angle of that frame. In PROBE, ALIGN, HOLD, IF_RAMP and HANDOVER the drive imposes a current
 * vector and controls it in the frame of that vector. With a sensor, READY goes straight to RUN, at
 * the angle of the sensor. Without a sensor and without a start-up (startup.current_hold is 0) it
 * does so too, and takes the rotor to be at angle 0.
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
 * Sets the heat that the winding starts with, Q24: 1 is the steady heat of the continuous current,
 * 0…DERATING_HEAT_MAX_Q24. Call between drive_init() and the first tick.
 */
void drive_warm(drive_t *drive, int32_t heat_q24);

/*
 * From the next drive_step() on the drive runs with `cfg`, which must stay valid until the next
 * change, or as long as the drive. config_check() must accept it, and its checksum must be right.
 *
 * If the checksum is equal, only the pointer changes.
 *
 * If config_change_refused() allows the change, the drive keeps its state. The measured corrections
 * of the motor model stay, as ratios to the new configured values. The voltage of the current
 * control stays too: the integrals take up the difference between the old model's voltage and the
 * new one's. A voltage drive goes back to current control. If a start is measuring, its measurement
 * begins again. Values that a slot of the slow schedule computes change in that slot, within a slow
 * period.
 *
 * Any other change makes the drive begin anew: it puts the gates into the safe state, goes to INIT,
 * calibrates, and forgets all that was measured of the motor. So the caller must ask
 * config_change_refused() first, and make such a change only at rest. A latched fault stays.
 *
 * Total and pure: a replay with the same change before the same frame repeats it bit for bit.
 * Context: control interrupt, right before drive_step().
 */
void drive_change(drive_t *drive, const drive_cfg_t *cfg);

/*
 * Whether the drive reads the temperature in the next tick, as it does once per slow period.
 * control_isr() takes the command in that tick, and the recorder looks for a change of command and
 * temperature. So a command waits for up to a slow period.
 */
static inline bool drive_reads_slow_inputs(const drive_t *drive)
{
    return schedule_next(drive) == (uint32_t)SLOT_CHECKS;
}

/* Whether the tick that has just ended has read them. Call after drive_step(). */
static inline bool drive_has_read_slow_inputs(const drive_t *drive)
{
    return drive->slow_count == (uint32_t)SLOT_CHECKS;
}

/* One control tick. Total: every input frame is allowed. Context: control interrupt only. */
void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out);

#endif
