/* SPDX-License-Identifier: MIT */
/*
 * The numbers of the board, in the units of the registers.
 *
 * They come from the board file: nfconfig checks them and writes them to hal_config.h
 * (host_sim/config/hal_header.cpp).
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* Ticks that the flight recorder goes on for after a fault. */
#define BOARD_RECORDER_POST_TICKS (64U)

typedef struct {
    uint32_t timer_counts;    /* timer counts of half a PWM period */
    uint32_t dead_time_ticks; /* dead time in ticks of the timer's clock */
    uint32_t adc_sampling_ns; /* least sampling time of the shunts */
    uint32_t amplifier_zero;  /* converter counts without current */
    bool amplifier_inverts;   /* current into the motor counts down */
    uint32_t pga_gain;        /* gain of the operational amplifiers: 1, 2, 4, 8, 16, 32, 64 */
    uint32_t trip_count;      /* level at the comparators' input, 4096: the reference voltage */
    /* true: a signal below that level is an over-current; false: a signal above it */
    bool trip_below;
    uint32_t baud; /* baud rate of the serial line */
} board_t;

extern const board_t BOARD;

/* Clock of the system, the timers and the buses. */
#define BOARD_CLOCK_HZ (170000000U)

#endif
