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

/* Returns the frame of the imposed vector. current: as vector_measure() returns it. */
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

/* A start begins: no current, no voltage, no integrals. */
void frame_reset(control_t *control);

/* Set i_d*, i_q* or both for the next ticks, Q15 of I_b, ±16384. */
static inline void frame_ask_d(control_t *control, int32_t current_d)
{
    control->current_ref.d = current_d;
}

static inline void frame_ask_q(control_t *control, int32_t current_q)
{
    control->current_ref.q = current_q;
}

static inline void frame_ask(control_t *control, dq_t current)
{
    control->current_ref = current;
}

/* Runs current_loop_plan() with these gains, in a frame that turns at this speed. */
void frame_plan_with(control_t *control, const drive_t *drive, const current_loop_cfg_t *loop,
                     step_t speed);

/*
 * Runs current_loop_plan() in the frame of the rotor. Call it in RUN when current_ref, the model or
 * ω̂ may have changed.
 */
void frame_plan_rotor(control_t *control, const drive_t *drive);

/* The same in the frame of the present state; below RUN it is the frame of the imposed vector. */
void frame_plan(control_t *control, const drive_t *drive);

/* Returns the voltage that the model needs for current_ref by the last plan, Q15 of U_b. */
static inline dq_t frame_model_voltage(const control_t *control)
{
    return current_loop_model(&control->current_loop, control->current_ref);
}

/*
 * One tick of the current control (current_loop.h). Returns the voltage for current_ref, Q15 of
 * U_b. current: measured, in the frame of the control. bus: at this instant, Q15 of U_b.
 */
dq_t frame_control_current(control_t *control, const drive_t *drive, const current_loop_cfg_t *loop,
                           dq_t current, int32_t bus);

/*
 * The same for an imposed current. It plans in each tick, and adds the whole gain of RUN to a
 * current beyond along_max and across_max.
 */
dq_t frame_impose_current(control_t *control, const drive_t *drive, const frame_t *frame,
                          int32_t bus);

/*
 * Demands a voltage (Q15 of U_b): turns it into compare values, with the angle that the frame will
 * have in the middle of the period in which the voltage acts.
 */
void frame_modulate(control_t *control, const drive_t *drive, const frame_t *frame, dq_t voltage,
                    compare_t *out);

/* The same in the frame of the vector, without compensation of the dead time and voltage drop. */
void frame_modulate_plain(control_t *control, const drive_t *drive, dq_t voltage, compare_t *out);

/* The last tick was late: zero voltage acts in place of its demand. */
void frame_lose_demand(control_t *control);

/*
 * Change to a frame that is ahead by `angle`. current_ref and the integrals of the current control
 * are turned back by that angle. So they stay as they are in space, and nothing jumps.
 */
void frame_turn(control_t *control, angle_t angle);

/*
 * Current control goes on after the voltage drive, from the present voltage and this mean current:
 * i_q* is the mean of i_q, and i_d* is 0. The compensator has kept i_d near 0, and a configuration
 * without start-up may have no slope that would bring another i_d* to 0. The integrals take the
 * part of the voltage that the model does not explain.
 */
void frame_resume(control_t *control, const drive_t *drive, dq_t mean);

/*
 * Sets the integral along d to the present voltage minus `modelled`: the voltage along d that the
 * model and the compensation supply from now on.
 */
void frame_rest_to_integral_d(control_t *control, int32_t modelled);

/* Adds `voltage` to the integrals, because the model no longer gives it. */
void frame_take_over(control_t *control, dq_t voltage);

#endif
