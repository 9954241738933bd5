/* SPDX-License-Identifier: MIT */
/*
 * Whether an input is there, and what it says: the rule that voltage, servo pulses and DShot have
 * in common.
 *
 * A decoder tells of each reading whether it is good. The signal is there after
 * INPUT_SIGNAL_GOOD good readings in a row. It is lost when no good reading has come for the
 * time-out, or after as many bad readings in a row as its decoder says. Its value is the median of
 * the last three good readings, so a single wrong reading that looks good has no effect.
 *
 * Time is in control ticks: without ticks no time-out ends, and the motor does not move either.
 * Context: background. No function waits.
 */
#ifndef INPUT_SIGNAL_H
#define INPUT_SIGNAL_H

#include <stdbool.h>
#include <stdint.h>

#define INPUT_SIGNAL_GOOD (8U)
#define INPUT_SIGNAL_VALUES (3U)
#define INPUT_SIGNAL_BAD (8U)   /* bad pulses or frames in a row that lose the signal */
#define INPUT_SIGNAL_ANY (256U) /* bad readings that a voltage bears until its time runs out */

/* Why there is no signal. */
typedef enum {
    INPUT_LOST_NOT = 0,  /* there is one */
    INPUT_LOST_SILENT,   /* nothing comes */
    INPUT_LOST_NO_PIN,   /* the board has no such input */
    INPUT_LOST_LOW,      /* the voltage is below its range: an open or shorted wire */
    INPUT_LOST_HIGH,     /* the voltage is above its range: likewise */
    INPUT_LOST_SHAPE,    /* pulses come, but not with the widths and periods of this input */
    INPUT_LOST_CHECKSUM, /* frames come, but their checksums are wrong */
    INPUT_LOST_INVERTED, /* the line or its checksums are inverted: bidirectional DShot */
    INPUT_LOSSES
} input_lost_t;

typedef struct {
    uint16_t values[INPUT_SIGNAL_VALUES]; /* the last good readings */
    uint8_t good;  /* good readings in a row, at most INPUT_SIGNAL_GOOD; a present signal has all */
    uint8_t bad;   /* bad readings since the last good one, at most 255 */
    uint8_t why;   /* input_lost_t: what was wrong with the last bad one since a good one */
    uint8_t lost;  /* input_lost_t */
    uint8_t count; /* good readings so far, wrapping */
    bool noisy;    /* a bad reading has come since the last input_signal_was_noisy() */
    uint32_t heard; /* tick of the last good reading */
} input_signal_t;

/* No signal. tick: the present tick. */
void input_signal_init(input_signal_t *signal, uint32_t tick);

/* A good reading. value: 0…65535. */
void input_signal_good(input_signal_t *signal, uint32_t value, uint32_t tick);

/* A bad reading. most: so many in a row lose the signal, INPUT_SIGNAL_BAD or INPUT_SIGNAL_ANY. */
void input_signal_bad(input_signal_t *signal, input_lost_t why, uint32_t most);

/* Call once per pass. timeout_ticks: 0…2^30. */
void input_signal_step(input_signal_t *signal, uint32_t tick, uint32_t timeout_ticks);

/* Whether a bad reading has come since the last call. */
bool input_signal_was_noisy(input_signal_t *signal);

/* The value. Only of a signal that is not lost. */
uint32_t input_signal_value(const input_signal_t *signal);

/* The reason as the end of a sentence that begins with "the input is lost: ". Never NULL. */
const char *input_signal_text(uint32_t lost);

#endif
