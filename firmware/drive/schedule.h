/* SPDX-License-Identifier: MIT */
/*
 * The slow schedule. The work of a slow period is spread over its last ticks, one slot per tick, to
 * make the longest tick shorter. The number of a slot is the number of ticks left in the period.
 *
 *     slot     who                                              in which states  how often
 *     REFINE   motor_refine, estimate_refine                    HOLD to RUN      each period
 *     PHASES   monitor_phases; monitor_swing                    PROBE to RUN     each period
 *     CHECKS   monitor_next_check: four take turns              any              every fourth
 *     LIMITS   monitor_derate; run_plan_current_d               any; RUN         each period
 *     PLAN     run_plan, below RUN run_plan_vector too          HOLD to RUN      each period
 *     SPEED    the vector, in RUN the torque or the voltage     HOLD to RUN      each period
 *
 * Part of the drive; schedule_step() is called from drive_step only. control_isr() and the recorder
 * find the tick of the slot CHECKS with drive_reads_slow_inputs() (drive.h).
 */
#ifndef SCHEDULE_H
#define SCHEDULE_H

#include "instant.h"
#include "io.h"
#include "state.h"

typedef enum {
    SLOT_SPEED = 0,
    SLOT_PLAN,
    SLOT_LIMITS,
    SLOT_CHECKS,
    SLOT_PHASES,
    SLOT_REFINE,
    SLOTS /* number of slots, not a slot */
} slot_t;

/* Returns the number of the slot that the next tick has; SLOTS or more: it has none. */
static inline uint32_t schedule_next(const drive_t *drive)
{
    return (uint32_t)drive->slow_count - 1U;
}

/*
 * Does the work of one slot. moving: this tick controls a current and may run REFINE, PLAN and
 * SPEED; it is false in the tick in which the drive starts, which has measured nothing for them
 * yet, and in PROBE. Writes `fault` only when it returns DRIVE_EVENT_FAULT.
 */
drive_event_t schedule_step(drive_t *drive, const drive_in_t *in, const instant_t *now, slot_t slot,
                            bool moving, fault_t *fault);

/* Changes from the voltage drive back to current control, without a jump of voltage or torque. */
void schedule_end_voltage_drive(drive_t *drive);

#endif
