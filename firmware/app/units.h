/* SPDX-License-Identifier: MIT */
/*
 * From the firmware's numbers to those of a person and back, for a console and the like.
 *
 * What gives the numbers their units are facts of motor and board, each as it is known, not factors made of several of them:
 * pole pairs, the tick in ps, full scales in millionths (µA, µV). They fit 32 bits for all that the keys of motor and board
 * file allow: 1…50 pole pairs, a tick of 10^7…5·10^8 ps (100…2 kHz), up to 2000 A and V. Products are 64 bits wide and exact.
 *
 * Pure functions. Context: background; a 64-bit division is some hundred instructions.
 */
#ifndef UNITS_H
#define UNITS_H

#include "fx.h"

#include <stdint.h>

/* How the angle advances. pole_pairs · tick_ps within 10^7…2.5·10^10. */
typedef struct {
    uint32_t pole_pairs;
    uint32_t tick_ps; /* a control tick, which is a PWM period */
} units_rotation_t;

/* Mechanical speed, rpm, of an electrical one, rounded to the nearest. Any step. */
int32_t units_rpm(const units_rotation_t *rotation, step_t step);

/* Electrical speed of a mechanical one, rounded to the nearest; any rpm, saturated at the last whole one that a step_t holds. */
step_t units_step(const units_rotation_t *rotation, int32_t rpm);

/*
 * value / one of a base, in thousandths of its unit, rounded towards zero. one: 1…2^15, what stands for the base;
 * base_millionths: the base in millionths of its unit. Saturated at ±INT32_MAX.
 */
int32_t units_thousandths(int32_t value, int32_t one, uint32_t base_millionths);

#endif
