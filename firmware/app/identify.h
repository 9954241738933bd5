/* SPDX-License-Identifier: MIT */
/*
 * The drive measures its own motor: which experiments follow each other, and with which current and speed.
 *
 * The background asks the drive for one experiment at a time by the words of probe.h, waits for its window, and sends the
 * sums as a line of text, a record. Whoever has the records and the board's files makes a motor file of them
 * (`motorsim identify`). What an experiment needs of those before it, a gain of the current control or how steep a ramp may
 * be, is computed here, to some per cent.
 *
 *   PULSE   voltage pulses on the axes of the three phases, each larger than those before, until a quarter of the continuous
 *           current flows: are the phases connected, and what is L
 *   CATCH   half a turn with the continuous current takes the rotor along
 *   STILL   on the axis of each phase: voltage over current, at 14 currents; then pulses along and across the current
 *   SPIN    the vector turns at a quarter of the speed, at half of it and at the whole
 *   RAMP    down to half of the speed and up again, as steep as lets the rotor lag by about 17 degrees
 *   COAST   no current, the frame follows the rotor
 *
 * No rule knows a motor. Currents are shares of those of the name plate, times are periods of a rectified mains, or ticks
 * of the current control, which follows the measured L. The highest speed is half of that of the name plate, and less where
 * the bus does not reach that.
 *
 * Records. `= KIND` and 19 numbers: axis, current, speed, pulse along, pulse across, quarter, ticks; the sums of
 * probe_sums_t in their order. KIND: pulse, catch, still, burst (pulses on a current), spin, ramp, hold (the speed after a
 * ramp), coast. A first line gives their scales: `identify 1`, tick in ps, full scale of the current in µA and of the bus in
 * µV, pole pairs, and the shift of speeds (drive_cfg_t.speed_shift).
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
    IDENTIFY_BEGINS, /* it says the scales of its records, and asks the drive to PROBE */
    IDENTIFY_PULSE,
    IDENTIFY_CATCH,
    IDENTIFY_STILL,
    IDENTIFY_SPIN,
    IDENTIFY_RAMP,
    IDENTIFY_COAST,
    IDENTIFY_ENDS /* it says how it has ended, and opens the gates */
} identify_phase_t;

#define IDENTIFY_WORDS ((uint32_t)PROBE_WORDS - (uint32_t)PROBE_CURRENT)
#define IDENTIFY_AXES (3U)

/* One experiment. */
typedef struct {
    int32_t words[IDENTIFY_WORDS]; /* of probe.h, from PROBE_CURRENT on */
    const char *kind;              /* first word of its record */
    uint32_t
        settle; /* ticks from the vector's arrival to the window; with `leads` from there to the words */
    uint32_t ticks; /* of the window */
    bool leads;     /* the window begins, and then the words are asked for */
    bool rushes;    /* the window does not wait for the vector's arrival */
} identify_aim_t;

typedef enum {
    IDENTIFY_LEADING = 0, /* the window is open, its words are not asked for yet */
    IDENTIFY_ASKING,      /* word by word */
    IDENTIFY_MOVING,      /* the vector has not arrived */
    IDENTIFY_SETTLING,
    IDENTIFY_MEASURING
} identify_wait_t;

/* What PULSE, CATCH and STILL have found, and where they are. */
typedef struct {
    uint32_t axis;
    int32_t pulse;             /* V of the pulses */
    uint32_t quarter;          /* and their ticks */
    bool fine;                 /* they are 5/4 of those before */
    int32_t before;            /* largest current of those before */
    dq_t peaks[IDENTIFY_AXES]; /* current of the last pulses, in the frame of each axis */
    int32_t inductance_q16;    /* volt-ticks for a change of the current, Q15 of U_b and I_b, Q16 */
    int32_t along_q16;         /* the same along and across a current, of the last pulses */
    int32_t across_q16;
    int32_t high_voltage; /* means at the largest current of this axis */
    int32_t high_current;
    int32_t resistance_q13[IDENTIFY_AXES]; /* U_b/I_b */
    int32_t loss;                          /* of the voltage at no current, Q15 of U_b */
} identify_rest_t;

/* Of SPIN, RAMP and COAST. */
typedef struct {
    step_t top; /* highest speed */
    uint32_t ramp_ticks;
    uint32_t swing_ticks; /* 1/ω_n of the rotor in the field of the current; 0: not known */
    int32_t flux_q14;     /* φ as it showed, U_b/Ω_b */
    int32_t pull_down;    /* torque of the last ramps over what the current can pull, Q14 */
    int32_t pull_up;
    uint32_t pairs_left; /* of ramps, and 1; 0: still becoming steeper */
    uint32_t coast_ticks;
    int32_t coast_speed; /* at first */
} identify_turn_t;

typedef struct {
    app_t *app;
    const about_t *about;
    identify_phase_t phase;
    uint32_t step;         /* experiments of the phase so far */
    identify_phase_t said; /* the last phase that was said */
    const char *why;       /* it was refused; NULL: it was not */
    identify_aim_t aim;
    int32_t in_force[IDENTIFY_WORDS];
    identify_wait_t wait;
    uint32_t since;    /* tick in which the wait began */
    uint32_t windows;  /* so far */
    uint32_t ms_ticks; /* of a millisecond, at least 1 */
    identify_rest_t rest;
    identify_turn_t turn;
} identify_t;

void identify_init(identify_t *identify, app_t *app, const about_t *about);

/* Begin. Returns NULL, or why it is refused: the drive is not READY. */
const char *identify_start(identify_t *identify);

/* Whether it has begun and not ended. */
bool identify_is_busy(const identify_t *identify);

/* End it: the gates open. Nothing happens when it is not busy. */
void identify_stop(identify_t *identify);

/* One pass of the background, once a tick or less often. Appends at most one line to `text`, which has room for it. */
void identify_step(identify_t *identify, text_t *text);

#endif
