/* SPDX-License-Identifier: MIT */
/*
 * Computes the power stage's temperature from the converter's counts, by the line of the board
 * file.
 */
#ifndef TEMPERATURE_H
#define TEMPERATURE_H

#include <stdint.h>

#define TEMPERATURE_POINTS_MAX (16U)

typedef struct {
    int32_t count;
    int32_t mc; /* m°C */
} temperature_point_t;

/*
 * Points of the line. From each point to the next the temperature rises, within ±250 °C. The counts
 * rise from point to point, or they fall, within 0…4096.
 */
typedef struct {
    uint32_t points; /* number of points, 2…16 */
    temperature_point_t at[TEMPERATURE_POINTS_MAX];
} temperature_line_t;

/*
 * Returns the temperature in °C, rounded to nearest, halves away from 0. It is linear between two
 * points. Beyond an end, as with an open or shorted sensor, it is the temperature of this end.
 * Context: any.
 */
int32_t temperature_celsius(const temperature_line_t *line, uint16_t count);

#endif
