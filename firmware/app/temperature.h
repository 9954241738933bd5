/* SPDX-License-Identifier: MIT */
/*
 * The power stage's temperature from its converter's counts, by the line of the board file.
 */
#ifndef TEMPERATURE_H
#define TEMPERATURE_H

#include <stdint.h>

#define TEMPERATURE_POINTS_MAX (16U)

typedef struct {
    int32_t count;
    int32_t mc; /* m°C */
} temperature_point_t;

/* m°C rise from each point to the next, within ±250 °C; counts rise, or fall, within 0…4096. */
typedef struct {
    uint32_t points; /* 2 to 16 */
    temperature_point_t at[TEMPERATURE_POINTS_MAX];
} temperature_line_t;

/*
 * °C, rounded to nearest, halves away from 0. Linear between two points; beyond the ends it is the
 * temperature of the end, as for a sensor that is open or shorted. Context: any.
 */
int32_t temperature_celsius(const temperature_line_t *line, uint16_t count);

#endif
