/* SPDX-License-Identifier: MIT */
/*
 * The electrical angle from three Hall signals.
 *
 * A pattern of the signals is a sector of some 60°. An edge from one sector to its neighbour tells
 * the angle exactly, and two edges in the same direction tell the speed. Between edges the angle
 * goes on with that speed, but not out of the sector. At an edge the angle takes on 3/4 of its
 * error, and the speed half of the difference. Where the time of the edge within its tick is not
 * known, it is half and a quarter, so that this jitter does not pass on as it is. After an error of
 * 15° or more, or where no speed was known, both are set.
 *
 * A rotor that is too fast to stop within a sector does not wait for a late edge: the angle goes on
 * with its speed. It is lost where four sectors should have passed.
 *
 * Where no speed is known the angle goes to the middle of the sector. It is off by at most half a
 * sector then, so a torque at standstill has cos 30° of its value or more.
 *
 * A pattern counts once it is there in two ticks in a row, so a disturbance of one tick is not
 * seen. The angle allows for this. An edge that comes far too soon for a steady speed
 * waits: it may be a signal that begins to stand still. While the speed changes, as after a start,
 * no edge waits. A pattern that passes over a sector is named JUMP.
 *
 * A signal that stands still makes an illegal pattern, 000 or 111, once in each electrical turn.
 * The signal for which the rotor would be where its speed has brought it is left out from then on,
 * and named. The other two tell sectors of 60° and 120° apart. If no speed is known, the angle is
 * lost. So it is where a second signal stands still: at the first edge at which a fast rotor seems
 * to turn back, and while a signal is left out, at the second one of any rotor. All three signals
 * of an open connector are found where the next edge is due.
 *
 * Pure, total; call from the control interrupt.
 */
#ifndef HALL_H
#define HALL_H

#include "fx.h"
#include "shaft_trouble.h"

#include <stdbool.h>
#include <stdint.h>

#define HALL_SECTORS (6U)

/* Reading of a tick. */
typedef struct {
    uint32_t pattern; /* 0…7 */
    /* of the last edge, Q8 of a tick, more than a tick counts as one; 0: it is not known */
    uint32_t age_q8;
} hall_reading_t;

typedef struct {
    /*
     * pattern of each sector, three bits each, sector 0 in the lowest; bit 0 of a pattern is sensor
     * 1. Two patterns of neighbours differ in one bit, and neither 0 nor 7 occurs
     */
    uint32_t patterns;
    /* angle at which sector k begins, 2^16 = one electrical turn, each ahead of the one before */
    uint32_t edges_q16[HALL_SECTORS];
    step_t fast_speed; /* a rotor of this speed or more cannot stop within a sector, 1…2^29 */
} hall_cfg_t;

/* Sectors that a pattern stands for. */
typedef struct {
    uint8_t first; /* 0…5 */
    uint8_t count; /* 1 or 2; 0: the pattern is illegal */
} hall_span_t;

typedef struct {
    angle_t angle;     /* electrical */
    step_t speed;      /* from edge to edge, 0 where it is not known */
    step_t pace;       /* speed at the last edge, 0 where it is not known */
    angle_t edge;      /* angle of the last edge */
    uint32_t ticks;    /* since the last edge, saturates at 2^20 */
    uint32_t patience; /* of these, within which the next edge has to come, at most 2^20 */
    hall_span_t span;  /* in which the rotor is */
    /* how long before the tick that saw it first the last edge was, and the edge to `seen`: Q8 */
    uint16_t edge_age_q8;
    uint16_t seen_age_q8;
    int8_t direction; /* of the last edge: 1, −1; 0: none yet */
    uint8_t seen;     /* pattern of the last tick */
    uint8_t taken;    /* pattern that counts */
    uint8_t unlike;   /* ticks in a row with a pattern that no angle has, at most 4 */
    uint8_t dead;     /* bit of the signal that is left out; 0: none */
    uint8_t trouble;  /* shaft_trouble_t that was found in this tick */
    bool turned;      /* the last edge was passed the other way than the one before */
    bool timed;       /* the edge to `seen` has a time of its own */
    bool paced;       /* the speed is known */
    bool steady;      /* and that of the sector before was about the same, or it is fast */
    bool fast;        /* it cannot stop within a sector, as of the last edge */
    bool known;       /* the angle is known */
} hall_t;

/* The angle is not known. */
void hall_start(hall_t *hall);

/* One tick. Returns whether `angle` is known. |speed| stays below 2^29. */
bool hall_step(hall_t *hall, const hall_cfg_t *cfg, hall_reading_t reading);

/* Whether neighbours in `patterns` differ in one bit and all six legal patterns occur. Pure. */
bool hall_order_holds(uint32_t patterns);

#endif
