/* SPDX-License-Identifier: MIT */
/*
 * The motion loops: how a target becomes a speed reference, and how that becomes a torque. Each
 * function here runs once per slow period, or when a state begins.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef RUN_H
#define RUN_H

#include "instant.h"
#include "io.h"
#include "state.h"

/*
 * Nothing is asked for, and the rotor counts as at rest at angle 0. Without a sensor positions
 * count from there; with one the zero of positions stays, and if the last run ended in position
 * control, the next one begins in it.
 */
void run_reset(motion_t *motion, const drive_t *drive);

/*
 * A calibration begins: forgets J, because J was learned from the speed that the observer saw
 * before the fault.
 */
void run_forget_inertia(motion_t *motion);

/* Another configuration is in force; before: the one that was. */
void run_change(motion_t *motion, const drive_t *drive, const drive_cfg_t *before);

/* RUN begins with the torque that acts: no slope from an earlier change of the mode is left. */
void run_start(motion_t *motion, const drive_t *drive);

/* Current control goes on after the voltage drive, with the torque that acts. */
void run_resume(motion_t *motion, const drive_t *drive);

/* A flying start has found the rotor at this speed. */
void run_catch(motion_t *motion, step_t speed);

/* The sensor knows the rotor: the loops begin at its position and its speed. */
void run_catch_sensed(motion_t *motion, const drive_t *drive);

/* The rotor stands; the reference is 0. */
void run_stand(motion_t *motion);

/* Sets the bandwidth of the speed loop: half of it while L is not known or the motion has swung. */
void run_set_bandwidth(motion_t *motion, bool low);

/* The integral of the speed loop begins with this torque of the load, i_q in Q15 of I_b. */
void run_take_load(motion_t *motion, int32_t load);

/*
 * Makes the present position the zero of positions; in position control the position of the
 * profile. Call only when drive_knows_rotor() is true.
 */
void run_set_zero(motion_t *motion, const drive_t *drive);

/*
 * Changes the mode without a jump: the position profile begins with this position and the present
 * speed reference, the torque with the torque that acts. The torque that the new mode demands may
 * be very different: a commanded torque differs from the torque of the speed loop, and the ramp of
 * a profile differs from the ramp of the speed. So the torque changes on a slope
 * (torque_loop_bridge()). Whole turns that the rotor made outside position control do not count.
 */
void run_change_mode(motion_t *motion, const drive_t *drive, uint8_t mode,
                     const rotor_position_t *position);

/*
 * Computes the speed reference of the next slow period: a ramp, a position profile, or the speed to
 * which a torque leads. position: of the frame in which the currents are controlled.
 */
void run_plan(motion_t *motion, const drive_t *drive, const drive_command_t *command,
              const rotor_position_t *position);

/*
 * After run_plan() with an imposed vector: the vector does not wait for the rotor, so its ramp is
 * slow enough to leave torque for load and inertia. has_to_stand: the vector comes to rest first.
 */
void run_plan_vector(motion_t *motion, const drive_t *drive, bool has_to_stand);

/* Sets the range of i_q* of this slow period. */
void run_allow(motion_t *motion, torque_range_t range);

/*
 * In RUN under current control, after run_allow(): returns i_d* of the next slow period, and
 * narrows the range of i_q* to what it leaves.
 */
int32_t run_plan_current_d(motion_t *motion, const drive_t *drive, const instant_t *now);

/* In RUN under current control: runs the speed loop or the torque loop. Returns i_q*. */
int32_t run_step_torque(motion_t *motion, const drive_t *drive);

/*
 * Returns the change of speed that is expected in this slow period, when i_q* has been set. before:
 * the speed reference before run_step_torque().
 */
step_t run_expected_change(const drive_t *drive, step_t before);

/* With an imposed vector: moves the speed reference on its ramp. Returns i_q* of the ramp. */
int32_t run_accelerate(motion_t *motion, const drive_t *drive);

/* Under the voltage drive: the speed reference is the planned one at once. */
void run_follow_command(motion_t *motion, const drive_t *drive);

/*
 * Whether to change back to an imposed current: i_d* has risen to it, and the speed reference is so
 * far below the lowest speed of RUN that voltage and torque have settled. The voltage that makes
 * i_d rise differs from the voltage that holds it. In speed and torque mode the reference follows
 * the ramp of the imposed vector below the lowest speed, so 3/4 of the lowest speed is low enough.
 * At lower speed the weak EMF may lose the rotor. A position profile still brakes at 3/4, so it has
 * to reach 1/2.
 */
bool run_is_to_be_held(const drive_t *drive);

#endif
