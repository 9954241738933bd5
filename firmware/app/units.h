/* SPDX-License-Identifier: MIT */
/*
 * Converts between the firmware's numbers and rpm, A or V, for a console or a display.
 *
 * The scales are facts of motor and board: pole pairs, the tick in ps, full scales in millionths
 * (µA, µV). They fit 32 bits over the whole range of the keys of motor and board file: 1…50 pole
 * pairs, a tick of 10^7…5·10^8 ps (100…2 kHz), up to 2000 A and V. Products are 64 bits wide and
 * exact.
 *
 * Pure functions. Context: background; a 64-bit division takes some hundred instructions.
 */
#ifndef UNITS_H
#define UNITS_H

#include "fx.h"

#include <stdint.h>

/* Scale of speeds. Range: pole_pairs · tick_ps is 10^7…2.5·10^10. */
typedef struct {
    uint32_t pole_pairs;
    uint32_t tick_ps; /* length of a control tick, which is a PWM period */
} units_rotation_t;

/* Converts electrical speed to mechanical rpm, rounded to nearest. Range: any step. */
int32_t units_rpm(const units_rotation_t *rotation, step_t step);

/*
 * Converts mechanical rpm to electrical speed, rounded to nearest. Range: any rpm; saturates at the
 * last whole rpm that a step_t can hold.
 */
step_t units_step(const units_rotation_t *rotation, int32_t rpm);

/*
 * Converts a position in Q16 electrical turns to hundredths of a turn of the shaft, rounded to
 * nearest. Range: any position.
 */
int32_t units_hundredth_turns(const units_rotation_t *rotation, int32_t position);

/*
 * Returns the frequency of `halves` half-waves in `ticks` ticks, in tenths of Hz, rounded to
 * nearest, saturated at INT32_MAX; 0 for 0 ticks. halves: 0…1000.
 */
int32_t units_decihertz(const units_rotation_t *rotation, uint32_t halves, uint32_t ticks);

/* Returns the ticks in `us` µs, rounded down, and at least 1. us: 1…10^7. */
uint32_t units_ticks(const units_rotation_t *rotation, uint32_t us);

/*
 * Returns T_b = 1.5·P·U_b·I_b/Ω_b in µN·m (P: pole pairs), saturated at 2^46, within 0.1 % where
 * U_b·I_b is 1 W or more. Full scales: from about_t. speed_shift: from the configuration, 1…16.
 */
int64_t units_torque_base(const units_rotation_t *rotation, uint32_t current_full_scale_ua,
                          uint32_t bus_full_scale_uv, uint32_t speed_shift);

/*
 * Converts a torque in Q28 of T_b to µN·m, rounded towards zero, saturated at ±INT32_MAX. base: T_b
 * in µN·m, 0…2^46; torque_q28: any.
 */
int32_t units_torque(int64_t base, int32_t torque_q28);

/*
 * Converts a torque in µN·m to Q28 of T_b, rounded towards zero, saturated at ±INT32_MAX; 0 if T_b
 * is 0. base: T_b in µN·m; torque: any.
 */
int32_t units_torque_q28(int64_t base, int32_t torque);

/*
 * Converts a per-unit value to thousandths of its unit, rounded towards zero, saturated at
 * ±INT32_MAX. one: the value that stands for the base, 1…2^15. base_millionths: the base in
 * millionths of its unit.
 */
int32_t units_thousandths(int32_t value, int32_t one, uint32_t base_millionths);

#endif
