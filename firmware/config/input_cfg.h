/* SPDX-License-Identifier: MIT */
/*
 * Settings of the input that commands the drive without a PC (input.h), of its button, and of the
 * console.
 *
 * A reading is a whole number in the unit of the kind:
 *
 *     INPUT_KIND_VOLTAGE    Q15 of the converter's full scale
 *     INPUT_KIND_RC_PULSE   width of a pulse, 1/HAL_PULSE_HZ = 0.1 µs
 *     INPUT_KIND_DSHOT      throttle of a frame less 47: 1…2000
 */
#ifndef INPUT_CFG_H
#define INPUT_CFG_H

#include <stdint.h>

typedef enum {
    INPUT_KIND_NONE = 0,
    INPUT_KIND_VOLTAGE,  /* a potentiometer, or another voltage */
    INPUT_KIND_RC_PULSE, /* servo pulses of a receiver */
    INPUT_KIND_DSHOT,    /* DShot 150, 300 or 600 of a flight controller */
    INPUT_KINDS
} input_kind_t;

/* What the largest reading commands the most of. */
typedef enum {
    INPUT_COMMANDS_SPEED = 0,
    INPUT_COMMANDS_TORQUE
} input_commands_t;

typedef enum {
    INPUT_BUTTON_NONE = 0,
    INPUT_BUTTON_ENABLE,    /* the motor runs only while it is pressed */
    INPUT_BUTTON_START_STOP /* a press starts, the next one stops */
} input_button_t;

/* The reading of an input lies so: least ≤ low ≤ middle < high ≤ most. throttle.h uses it. */
typedef struct {
    uint32_t kind;     /* an input_kind_t */
    uint32_t commands; /* an input_commands_t */
    uint32_t button;   /* an input_button_t */
    int32_t least;     /* a lower reading is no reading, but a fault of the line; 0…32767 */
    int32_t low;       /* full backwards; 0…32767 */
    int32_t middle;    /* no demand; `low` where the input commands one way only; 0…32767 */
    int32_t high;      /* full forwards; 0…32767 */
    int32_t most;      /* a higher reading is no reading; 0…32767 */
    int32_t dead_q15;  /* share of each side around the middle that is no demand, 0…16384 */
    int32_t expo_q15;  /* share of the cube in the curve, 0…32767; 0: a straight line */
    /* share of the largest speed or torque at `high`, ±32767; negative: the other direction */
    int32_t share_q15;
    int32_t slope_q30;      /* the demand changes by at most this in a tick, 0…2^30 − 1: up to 1 */
    int32_t filter_q15;     /* low-pass of a voltage: share of the change in a tick, 0…32767 */
    uint32_t timeout_ticks; /* the input is lost after so long without a good reading, 0…2^30 */
    uint32_t arm_ticks;     /* the input has to be seen at rest for so long, 0…2^30 */
} input_cfg_t;

typedef struct {
    /*
     * the drive stops after this many ticks without a typed byte, 0…2^30; 0: it does not stop for
     * this reason
     */
    uint32_t timeout_ticks;
} console_cfg_t;

#endif
