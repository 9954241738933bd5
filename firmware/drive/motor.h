/* SPDX-License-Identifier: MIT */
/*
 * What the drive knows of the motor: the model in force (model.h), and whether R and L of it were
 * measured. It is kept from run to run.
 *
 * Part of the drive; control interrupt only.
 */
#ifndef MOTOR_H
#define MOTOR_H

#include "state.h"

/* Nothing is known: the model is the configured one. */
void motor_reset(motor_t *motor, const drive_cfg_t *cfg);

/* Take over another configuration; the measured ratios stay (model_change()). */
void motor_change(motor_t *motor, const drive_cfg_t *cfg);

/* Take over values that a start has measured, within the configured limits (model_set()). */
void motor_set(motor_t *motor, const drive_cfg_t *cfg, const model_measured_t *measured);

/* R and L count as measured from now on: a measurement that fails is not repeated. */
void motor_identify(motor_t *motor);

/* Apply the shares of the gains that belong to this speed (model_pace()). */
void motor_pace(motor_t *motor, const drive_cfg_t *cfg, step_t speed);

/*
 * Once per slow period: corrects the flux with the observer's error, and the gains when `calm`, the
 * speed as estimate_calm_speed() returns it, asks for others.
 */
void motor_refine(motor_t *motor, const drive_cfg_t *cfg, const nn_observer_t *observer,
                  step_t calm);

/* Whether the words of a part are as they were written; computes those of the flux again. */
bool motor_check(motor_t *motor, const drive_cfg_t *cfg, model_part_t part);

/* Returns the magnitude of the EMF at this speed, both Q15 of their bases. speed_q15: 0…32767.
 * Pure. */
int32_t motor_emf(const motor_t *motor, int32_t speed_q15);

#endif
