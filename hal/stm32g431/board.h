/* SPDX-License-Identifier: MIT */
/*
 * What this image knows about its board, in the units that the registers want.
 *
 * The numbers come from the board file by way of hal_config.h, which nfconfig writes after having
 * checked them (host_sim/config/hal_header.cpp).
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* The ticks that the flight recorder goes on for after a fault. */
#define BOARD_RECORDER_POST_TICKS (64U)

typedef struct {
    uint32_t timer_counts;    /* of half a PWM period */
    uint32_t dead_time_ticks; /* of the timer's clock */
    uint32_t adc_sampling_ns; /* sample switch closed at least as long, shunts */
    uint32_t amplifier_zero;  /* converter counts without current */
    bool amplifier_inverts;   /* current into the motor counts down */
    uint32_t pga_gain;        /* of the operational amplifiers: 1, 2, 4, 8, 16, 32, 64 */
    uint32_t trip_count;      /* of 4096 of the reference, at the comparators' input */
    bool trip_below;          /* over-current is below that level, not above */
    uint32_t baud;            /* of the serial line */
} board_t;

extern const board_t BOARD;

/* The system clock, and that of timer and buses. */
#define BOARD_CLOCK_HZ (170000000U)

#endif
