/* SPDX-License-Identifier: MIT */
/*
 * The frame in which the currents are controlled: in RUN the frame of the rotor, below RUN the
 * frame of the imposed vector.
 *
 * A frame_t holds all that current control and modulation need to know of the frame. It lives for
 * one tick. Part of the drive; called from drive_step only.
 */
#ifndef FRAME_H
#define FRAME_H

#include "state.h"

typedef struct {
    angle_t angle;                  /* angle of the frame at this instant */
    step_t step;                    /* turn of the frame per tick */
    dq_t current;                   /* measured current in this frame */
    const current_loop_cfg_t *loop; /* gains and decoupling */
    bool imposed;                   /* true: the frame of the imposed vector */
} frame_t;

/* Returns the frame of the rotor. current: as estimate_step() returns it. */
static inline frame_t frame_of_rotor(const drive_t *drive, dq_t current)
{
    return (frame_t){
        .angle = rotor_position_angle(&drive->rotor.position),
        .step = drive->rotor.observer.speed_out,
        .current = current,
        .loop = &drive->motor.model.run_loop,
        .imposed = false,
    };
}

/* Returns the frame of the imposed vector. current: as frame_measure() returns it. */
static inline frame_t frame_of_vector(const drive_t *drive, dq_t current)
{
    return (frame_t){
        .angle = rotor_position_angle(&drive->vector.position),
        .step = drive->vector.step,
        .current = current,
        .loop = &drive->motor.model.hold_loop,
        .imposed = true,
    };
}

/*
 * Below RUN, each tick: returns the measured current in the frame of the vector, Q15 of I_b,
 * ±34400, and filters it into vector.current_mean.
 */
dq_t frame_measure(drive_t *drive, sample_t sample);

/*
 * Runs current_loop_plan() in the frame of the rotor. Call it in RUN when current_ref, the model or
 * ω̂ may have changed.
 */
void frame_plan_rotor(drive_t *drive);

/*
 * In RUN and with an imposed current: plans, and returns the voltage that the model needs for
 * current_ref, Q15 of U_b.
 */
dq_t frame_model_voltage(drive_t *drive);

/*
 * One tick of the current control (current_loop.h). Returns the voltage for current_ref, Q15 of
 * U_b. current: measured, in the frame of the control. bus: at this instant, Q15 of U_b.
 */
dq_t frame_control_current(drive_t *drive, const current_loop_cfg_t *loop, dq_t current,
                           int32_t bus);

/*
 * The same for an imposed current. It plans in each tick, and adds the whole gain of RUN to a
 * current beyond along_max and across_max.
 */
dq_t frame_impose_current(drive_t *drive, const frame_t *frame, int32_t bus);

/*
 * Turns a voltage (Q15 of U_b) into compare values. It uses the angle that the frame will have in
 * the middle of the period in which the voltage acts.
 */
void frame_modulate(drive_t *drive, const frame_t *frame, dq_t voltage, compare_t *out);

/* The same in the frame of the vector, without compensation of the dead time and voltage drop. */
void frame_modulate_plain(drive_t *drive, dq_t voltage, compare_t *out);

/*
 * Change to a frame that is ahead by `angle`. current_ref and the integrals of the current control
 * are turned back by that angle. So they stay as they are in space, and nothing jumps.
 */
void frame_turn(drive_t *drive, angle_t angle);

#endif
