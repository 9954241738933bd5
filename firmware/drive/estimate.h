/* SPDX-License-Identifier: MIT */
/*
 * What the drive knows of the rotor: its angle θ̂ in `position` and its speed ω̂ in `observer.speed`.
 *
 * The network of the observer runs in every tick that controls a current. Its weight W2 is the
 * speed, and there are three sources for it:
 *     observer   in RUN, and above track_speed: the network is trained (22)
 *     sensor     when the board has one: the network is given the speed of the sensor and is not
 *                trained. A current error that the network cannot explain means that the sensor is
 *                wrong (OBSERVER_LOST)
 *     vector     at low speed: the network is given the speed of the imposed vector, and θ̂
 *                approaches its angle
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef ESTIMATE_H
#define ESTIMATE_H

#include "state.h"

/*
 * Forgets the rotor, but not what the sensor has tracked. θ̂ is 0. estimate_start() has to follow,
 * which begins the observer anew.
 */
void estimate_reset(rotor_t *rotor);

/*
 * Start at this speed and this current (Q15 of I_b, in the frame of θ̂). θ̂ stays. cfg: the observer
 * of the model, at the pace of this speed (motor_pace()).
 */
void estimate_start(rotor_t *rotor, const nn_observer_cfg_t *cfg, step_t speed, dq_t current);

/* Set θ̂ and the whole turns. */
void estimate_place(rotor_t *rotor, rotor_position_t position);

/*
 * Follows the sensor and chooses the source. While the source is the sensor, θ̂ and ω̂ are set to
 * its angle and its speed. In RUN the observer takes over above sensor.observer_above, the sensor
 * below sensor.sensor_below; θ̂ does not jump at either. A sensor that fails leaves RUN to the
 * observer, and so does one that would take over 1/8 turn or more away from it, with Hall signals
 * half a sector more. Returns whether the sensor that was the source has failed in this tick of
 * RUN. Call it first in each tick of a drive with a sensor, in every state.
 */
bool estimate_sense(rotor_t *rotor, const drive_t *drive, const drive_in_t *in);

/*
 * An alignment has ended, and the rotor lies along the vector: the zero of an encoder is known from
 * now on. It is kept until the drive is set up anew or the encoder fails.
 */
void estimate_align_sensor(rotor_t *rotor, const drive_t *drive);

/* Whether RUN may begin with the sensor where a vector is imposed now. */
bool estimate_may_take_sensor(const drive_t *drive);

/* The source is the sensor from now on. */
void estimate_take_sensor(rotor_t *rotor);

/*
 * From READY with a sensor: start with the angle and the speed of the rotor, and without current.
 */
void estimate_start_sensed(rotor_t *rotor, const nn_observer_cfg_t *cfg);

/*
 * Once per slow period of RUN: moves the estimated speed with the expected acceleration, without
 * waiting for an observer error. change: of the speed in this period, ±2^30, of which
 * run.acceleration_q14 is fed forward.
 */
void estimate_accelerate(rotor_t *rotor, const drive_t *drive, step_t change);

/*
 * Another configuration is in force: cfg is the observer of the changed model. flux_q27 and
 * saliency_q13: of the model before (nn_observer_change()).
 */
void estimate_change(rotor_t *rotor, const nn_observer_cfg_t *cfg, int32_t flux_q27,
                     int32_t saliency_q13);

/* Whether the network is trained in this tick. Call it while a vector is imposed, not in RUN. */
bool estimate_is_trained(const drive_t *drive);

/*
 * Returns the voltage that acted since the last instant, Q15 of U_b, saturated to 16 bits: the
 * ratio (Q15 of the bus) that acted, times the mean of the bus voltages at both instants. Pure.
 */
ab_t estimate_applied_voltage(ab_t ratio, int32_t bus_before, int32_t bus_now);

/*
 * In a tick that controls a current: the network predicts. Call estimate_train() or
 * estimate_follow() behind it. Returns the measured current in the frame of θ̂, Q15 of I_b, ±34400.
 */
dq_t estimate_step(rotor_t *rotor, const drive_t *drive, sample_t sample);

/* Trains the network: it adapts ω̂. */
void estimate_train(rotor_t *rotor, const drive_t *drive);

/* ω̂ is the speed of the sensor already, or else becomes that of the vector. */
void estimate_follow(rotor_t *rotor, const drive_t *drive);

/*
 * Call last in a tick that controls a current: advances θ̂ to the next instant (23). pulled: without
 * a sensor θ̂ also approaches the angle of the vector.
 */
void estimate_advance(rotor_t *rotor, const drive_t *drive, bool pulled);

/*
 * Returns the speed from which the observer computes ρ: its estimate when that is far from zero,
 * otherwise the speed reference. A swing of the estimate through zero would change the sign of ρ,
 * and the swing would go on by itself.
 */
step_t estimate_calm_speed(const drive_t *drive);

/*
 * Once per slow period, after motor_refine(): updates the residual, and computes the observer's ρ
 * and half step anew (nn_observer_refresh()). calm: as estimate_calm_speed() returns it. In RUN a
 * sensor whose angle is more than a quarter turn off fails, unless the voltage drive is enabled.
 */
void estimate_refine(rotor_t *rotor, const drive_t *drive, step_t calm);

#endif
