/* SPDX-License-Identifier: MIT */
/*
 * What the code of this binding asks of the board while it runs. What registers are set to is in
 * settings.c, the pins are in pins.c.
 *
 * All comes from the board file: nfconfig checks it and writes hal_config.h
 * (host_sim/config/hal_header.cpp, g4_header.cpp).
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* Ticks that the flight recorder goes on for after a fault. */
#define BOARD_RECORDER_POST_TICKS (64U)

/* The sensor of the shaft. */
typedef enum {
    BOARD_SHAFT_NONE,
    BOARD_SHAFT_HALL,
    BOARD_SHAFT_ENCODER, /* incremental */
    BOARD_SHAFT_ABSOLUTE /* with an SPI */
} board_shaft_t;

typedef struct {
    uint32_t timer_counts;   /* timer counts of half a PWM period */
    uint32_t amplifier_zero; /* converter counts without current */
    bool amplifier_inverts;  /* current into the motor counts down */
    bool measures_c;         /* there is a sensor of phase c */
    /* true: comparators at the shunts open the gates; false: a line of the gate driver does */
    bool has_comparators;
    /* a comparator trips when the signal is below the level, not above it */
    bool trip_below;
    /*
     * cycles of the oscillator in the chip in 2048 cycles of the crystal; 0: there is no crystal
     */
    uint32_t crystal_span;
    uint32_t wake_us;  /* time that the gate driver needs after its pins are set, 0 to 20000 */
    uint32_t led_port; /* address of the LED's port */
    uint32_t led_on;   /* words for GPIO_BSRR of that port; both 0: there is no LED */
    uint32_t led_off;
    bool has_throttle;
    bool has_button;
    bool button_low; /* the level while it is pressed */
    bool has_pulses; /* there is a command pin */
    board_shaft_t shaft;
    bool has_index;        /* the incremental encoder has an index */
    uint32_t hall_age_q24; /* ticks in a count of the timer of the Hall edges; 0: they have none */
} board_t;

extern const board_t BOARD;

/* Clock of the system, the timers and the buses. */
#define BOARD_CLOCK_HZ (170000000U)

#endif
