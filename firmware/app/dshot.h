/* SPDX-License-Identifier: MIT */
/*
 * DShot of a flight controller, with 150, 300 or 600 kbit/s, which the pulses themselves tell.
 *
 * A frame is 16 pulses with a constant period T of 6.67, 3.33 or 1.67 µs, the highest bit first. A
 * bit that is 1 is high for 3/4·T, one that is 0 for 3/8·T. The first 11 bits are the value: 0
 * stops, 1 to 47 are commands, 48 to 2047 are the throttle. The next bit asks for telemetry. The
 * last four are the checksum: the exclusive or of the three groups of four bits before them.
 *
 * The rules. T, the mean of the 15 periods, is within 1/8 of one of the three. Each period is
 * within 1/4 of the first one. A width is a 0 from 3/16·T to 9/16·T and a 1 from there to 15/16·T.
 * At least 1.5·T without a rising edge lie before and after a frame. A frame that breaks a rule is
 * bad. INPUT_SIGNAL_BAD of them in a row lose the signal, without waiting for its time-out: a
 * checksum of four bits lets one of 16 random frames pass.
 *
 * What is not supported. Bidirectional DShot inverts line and checksum and waits for an answer: it
 * is recognised by its inverted checksum or by a line that is high between the frames, and named
 * (INPUT_LOST_INVERTED). A command is not carried out: it counts as a good frame that stops, as it
 * is meant for a motor at rest. The request for telemetry is decoded and not answered: the pin is
 * an input. 3D mode, which splits the throttle, is not known: a two-way input has its middle at the
 * middle of the throttle.
 *
 * Pure functions on their state. Context: background; a pulse takes some 40 instructions.
 */
#ifndef DSHOT_H
#define DSHOT_H

#include "hal.h"
#include "input_signal.h"

#include <stdbool.h>
#include <stdint.h>

#define DSHOT_BITS (16U)
#define DSHOT_FIRST_THROTTLE (48U) /* a lower value stops or is a command */

/* A good frame. */
typedef struct {
    uint16_t value; /* 0…2047 */
    bool telemetry; /* it asks for telemetry */
} dshot_frame_t;

typedef struct {
    uint32_t start;             /* rising edge of the first pulse of the frame, 1/HAL_PULSE_HZ */
    uint32_t last;              /* and of the last pulse so far */
    uint32_t first_period;      /* from the first to the second one */
    uint8_t widths[DSHOT_BITS]; /* of its pulses, at most 255 */
    uint8_t count;              /* pulses so far: 0…DSHOT_BITS + 1, which is too many */
    bool spoilt;                /* a period of the frame is wrong */
    dshot_frame_t frame;        /* the last good frame */
} dshot_t;

/*
 * Takes the next pulse of the pin. Returns true when it shows that a good frame has ended before
 * it; dshot->frame is this frame. Tells the signal of a bad frame.
 */
bool dshot_take(dshot_t *dshot, const hal_pulse_t *pulse, input_signal_t *signal);

/*
 * Call once per pass, when no pulse waits that had ended before `now`, in 1/HAL_PULSE_HZ. Returns
 * true when a good frame has ended, as dshot_take().
 */
bool dshot_step(dshot_t *dshot, uint32_t now, input_signal_t *signal);

#endif
