/* SPDX-License-Identifier: MIT */
/*
 * What this image knows about its board, in the units that the registers want.
 *
 * The numbers come from motor and board file by way of hal_config.h, which nfconfig writes after having
 * checked them (host_sim/config/hal_header.cpp).
 */
#ifndef BOARD_H
#define BOARD_H

#include "units.h"

#include "temperature.h"

#include <stdbool.h>
#include <stdint.h>

/* The ticks that the flight recorder goes on for after a fault. */
#define BOARD_RECORDER_POST_TICKS (64U)

typedef struct {
    uint32_t timer_counts;          /* of half a PWM period */
    uint32_t dead_time_ticks;       /* of the timer's clock */
    uint32_t adc_sampling_ns;       /* sample switch closed at least as long, shunts */
    uint32_t amplifier_zero;        /* converter counts without current */
    bool amplifier_inverts;         /* current into the motor counts down */
    uint32_t pga_gain;              /* of the operational amplifiers: 1, 2, 4, 8, 16, 32, 64 */
    uint32_t trip_count;            /* of 4096 of the reference, at the comparators' input */
    bool trip_below;                /* over-current is below that level, not above */
    uint32_t current_full_scale_ua; /* ± */
    uint32_t bus_full_scale_uv;
    units_rotation_t rotation;
    int32_t speed_max_rpm;
    temperature_line_t temperature;
} board_t;

extern const board_t BOARD;

/* The system clock, and that of timer and buses. */
#define BOARD_CLOCK_HZ (170000000U)

/* What the two files are called, for the console. */
extern const char *const BOARD_NAME;

#endif
