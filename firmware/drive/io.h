/* SPDX-License-Identifier: MIT */
/*
 * Input and output of a control tick: the frames that a hardware binding exchanges with the drive,
 * and the user's command.
 */
#ifndef IO_H
#define IO_H

#include "modulator.h"

#include <stdbool.h>
#include <stdint.h>

/* The loop that drives. As the mode of a command it says what the target is. */
typedef enum {
    DRIVE_MODE_SPEED = 0, /* step_t, + turns α towards β */
    DRIVE_MODE_POSITION,  /* Q16 electrical turns from the zero in force (motion_loop.h) */
    DRIVE_MODE_TORQUE     /* Q28 of T_b (current_reference.h), + drives forwards */
} drive_mode_t;

/*
 * Added to a fault_id_t it is the mode of a command with FAIL. The target is then the fault's value
 * in the lower half and its limit in the upper half.
 */
#define DRIVE_MODE_FAULT (0x80U)

#define DRIVE_REQUEST_RUN (0x01U)   /* level: run while set */
#define DRIVE_REQUEST_CLEAR (0x02U) /* acknowledge a fault, only without RUN */
#define DRIVE_REQUEST_PROBE (0x04U) /* level: measure the motor while set, only without RUN */
/*
 * Level: while set, the present position is the zero that positions count from. In position control
 * the target counts as 0 meanwhile, so a drive at rest stays where it is. Allowed with RUN and
 * without it. Nothing happens while the drive does not know the rotor.
 */
#define DRIVE_REQUEST_ZERO (0x08U)
/* the background has found a fault; no other bit may be set. Without a valid fault it is a stop */
#define DRIVE_REQUEST_FAIL (0x10U)

#define DRIVE_FLAG_BREAK (0x0001U) /* the power stage opened the gates by itself */
/* The last tick ended too late: zero voltage acts in place of its demand. */
#define DRIVE_FLAG_LATE (0x0002U)

/* The sensor tells no angle in this tick. Bits 8 to 11 say why: a shaft_trouble_t. */
#define DRIVE_FLAG_NO_ANGLE (0x0004U)
#define DRIVE_TROUBLE_SHIFT (8U)
#define DRIVE_TROUBLE_MASK (0xFU)

/* The user's command. */
typedef struct {
    int32_t target; /* a value of the kind that `mode` names */
    /*
     * Kind of the target: a drive_mode_t; a probe_word_t (probe.h, 16 and above), which PROBE takes
     * as the value of this word; or DRIVE_MODE_FAULT and a fault_id_t. RUN takes any other value as
     * SPEED.
     */
    uint8_t mode;
    uint8_t request;
} drive_command_t;

/*
 * One input frame: raw ADC counts (straight binary, currents with zero at mid-scale) and command.
 * The temperature is measured at the power stage and may be some ticks old. The angle comes from a
 * sensor on the shaft: 2^16 = one turn, 0 where the magnet flux is along phase a, positive from a
 * towards b. An encoder's is 0 at any angle, and that of Hall sensors is electrical: 2^16 = one
 * electrical turn. Without a sensor it is 0.
 */
typedef struct {
    uint16_t adc_ia;
    uint16_t adc_ib;
    uint16_t adc_bus;
    uint16_t flags;
    drive_command_t command;
    /* This field comes after the command: before it, it would cost a Cortex-M0+ 57 instructions. */
    uint16_t adc_temperature;
    uint16_t angle;
} drive_in_t;

/* One output frame. */
typedef struct {
    compare_t compare;
    bool gate_enable;
} drive_out_t;

#endif
