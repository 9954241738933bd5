/* SPDX-License-Identifier: MIT */
/*
 * The drive measures its own motor: which experiments follow each other, and with which current and speed.
 *
 * The background asks the drive for one experiment at a time by the words of probe.h, waits for its window, and sends the sums as
 * a line of text. The lines are what is found; motorsim identify makes a motor file of them, on this board's files. What an
 * experiment needs of those before it (a gain for the current control, a speed) is computed here, to a few per cent.
 *
 *   PULSE   voltage pulses on three axes at rest, each twice as large as the one before, until a quarter of the continuous
 *           current flows: what the current control needs of L
 *   CATCH   half a turn with the continuous current takes the rotor along
 *   STILL   on the axis of each phase: voltage over current, 14 currents; then pulses along and across the current
 *   SPIN    the vector turns up to a speed, then up and down between that and half of it
 *   COAST   no current, the frame follows the rotor
 *
 * Nothing here depends on a motor: currents are shares of those of the name plate, times are counted in mains periods and in
 * ticks of the current control, which follows the measured L.
 *
 * Context: background.
 */
#ifndef IDENTIFY_H
#define IDENTIFY_H

#include "about.h"
#include "app.h"
#include "text.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    IDENTIFY_IDLE = 0,
    IDENTIFY_BEGINS, /* it says the scales of its lines */
    IDENTIFY_PULSE,
    IDENTIFY_CATCH,
    IDENTIFY_STILL,
    IDENTIFY_SPIN,
    IDENTIFY_RAMP,
    IDENTIFY_COAST,
    IDENTIFY_DONE,
    IDENTIFY_REFUSED
} identify_phase_t;

#define IDENTIFY_WORDS ((uint32_t)PROBE_WORDS - (uint32_t)PROBE_CURRENT)

/* One experiment. */
typedef struct {
    int32_t words[IDENTIFY_WORDS]; /* of probe.h, from PROBE_CURRENT on */
    const char *kind;              /* first word of its line */
    uint32_t settle;               /* ticks from the vector's arrival to the window */
    uint32_t ticks;                /* of the window */
} identify_aim_t;

typedef enum {
    IDENTIFY_ASKING = 0, /* word by word */
    IDENTIFY_LEADING,    /* the window is to begin before its words are asked for */
    IDENTIFY_MOVING,     /* the vector has not arrived */
    IDENTIFY_SETTLING,
    IDENTIFY_MEASURING
} identify_wait_t;

typedef struct {
    app_t *app;
    const about_t *about;
    identify_phase_t phase;
    const char *why; /* it was refused */
    uint32_t step;   /* of the phase */
    identify_aim_t aim;
    int32_t in_force[IDENTIFY_WORDS];
    identify_wait_t wait;
    bool leads;         /* the window begins before the words */
    bool rushes;        /* the window begins while the vector still changes its speed */
    uint32_t since;     /* tick in which the wait began */
    uint32_t windows;   /* so far */
    uint32_t axis;
    uint32_t ms_ticks;  /* of a millisecond, at least 1 */
    int32_t pulse;      /* V of the last pulse */
    uint32_t quarter;   /* its ticks */
    int32_t response;   /* its current */
    bool fine;          /* the last pulse was 5/4 of the one before */
    int32_t inductance_q16; /* V in Q15 of U_b for a change of 1 in Q15 of I_b in a tick */
    int32_t along_q16; /* the same along and across, of the last pulses */
    int32_t across_q16;
    int32_t resistance_q13;
    int32_t loss; /* Q15 of U_b */
    int32_t high_voltage; /* means of two points of the first axis */
    int32_t high_current;
    step_t top;
    step_t ramp;
    uint32_t ramp_ticks;
    uint32_t pairs_left;
    uint32_t swing_ticks; /* 1/ω_n of the rotor in the field of the current; 0: not known */
    int32_t pull_down;
    int32_t pull_up;
    uint32_t coast_ticks;
    int32_t coast_speed;
} identify_t;

void identify_init(identify_t *identify, app_t *app, const about_t *about);

/* Begin. Returns NULL, or why it is refused. */
const char *identify_start(identify_t *identify);

/* Give up, or end: the gates open. */
void identify_stop(identify_t *identify);

/* One pass of the background, once a tick or less often. `text` is empty; a line of a result is appended when one is there. */
void identify_step(identify_t *identify, text_t *text);

#endif
