/* SPDX-License-Identifier: MIT */
/*
 * Sine, cosine, arctangent and square root on integers, by table and linear interpolation.
 * Pure functions, no state, callable from any context; none can fail.
 */
#ifndef TRIG_H
#define TRIG_H

#include "fx.h"
#include "trig_table.h"

#include <stdint.h>

typedef struct {
    int32_t sin; /* Q15, −32767…32767 */
    int32_t cos; /* Q15, −32767…32767 */
} sincos_t;

/*
 * Sine and cosine of an angle.
 * angle: whole range. Result: Q15 with amplitude 32767, within 1 LSB of 32767·sin and 32767·cos
 * (interpolation over 1/1024 turn 0.15 LSB, table and slope 0.1 LSB, result rounding 0.5 LSB).
 */
static inline sincos_t trig_sincos(angle_t angle)
{
    const uint32_t index = angle >> TRIG_INDEX_SHIFT;
    const uint32_t fraction = (angle >> TRIG_FRACTION_SHIFT) & TRIG_FRACTION_MASK;
    /*@ split index; */
    const int32_t sine = trig_sin_table[index];
    const int32_t cosine = trig_sin_table[index + TRIG_SIN_QUARTER];
    sincos_t result;

    result.sin = trig_interpolate(sine, (int32_t)fraction);
    result.cos = trig_interpolate(cosine, (int32_t)fraction);
    /*@ merge index; */
    return result;
}

/*
 * Returns the direction of the vector (x, y): the angle from the x axis towards the y axis. x, y:
 * any scale, same format, whole 16-bit range. The result is within 2^-17 turn (0.003°) of the exact
 * direction of the integers given; (0, 0) gives 0. One unsigned division.
 */
angle_t trig_atan2(int16_t y, int16_t x);

/* Returns floor(√x). Range: any x. If x is Q30, the root is Q15. */
uint16_t trig_sqrt(uint32_t x);

#endif
