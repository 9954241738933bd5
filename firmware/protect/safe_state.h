/* SPDX-License-Identifier: MIT */
/*
 * The safe state: what the gates do while the drive drives nothing.
 *
 * Open gates are safe while the EMF stays below what the bus bears. Above that speed the diodes
 * rectify into the bus, so the motor is shorted by the three low sides instead. Its current is then
 * φ/L at most in the end, and brakes little. The gates open once the rotor is slow.
 *
 * The change of the current tells when: in the short circuit it is the EMF's, T/L·ω·φ in a tick, so
 * it measures what would charge the bus. No observer takes part, as its loss may be the fault. What
 * decays with L/R changes little. A phase whose wire is open, a sensor that stands still or one
 * that clips leaves a change that is large twice in each electrical turn. The gates open when no
 * change over span_ticks was large for settle_ticks, more than a turn.
 *
 * They do not open while the bus is above its limit: it has no room for the energy of the windings.
 * When both sensors are dead no change is large, and only a bus above its limit tells of a fast
 * rotor.
 *
 * Called from drive_step in each tick that drives nothing. Pure, total. Speeds are steps per tick,
 * currents Q15 of I_b, the bus Q15 of U_b.
 */
#ifndef SAFE_STATE_H
#define SAFE_STATE_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /* opening the gates is safe up to this speed, 0…2^29; 0: always, the motor is never shorted */
    step_t open_speed;
    uint32_t span_ticks; /* a change of the current is one over so many ticks, 0…1024 */
    int32_t change_min;  /* a smaller change is that of a rotor slow enough, Q15 of I_b, 0…32767 */
    /*
     * the gates open after so many ticks without a larger change and with the bus within its limit,
     * 0…2^20
     */
    uint32_t settle_ticks;
} safe_state_cfg_t;

typedef enum {
    SAFE_STATE_OPEN = 0,
    SAFE_STATE_SHORT, /* gates on, all low sides: the rotor is fast, or the bus above its limit */
    SAFE_STATE_BROKEN /* the power stage has opened the gates by itself: nothing closes them */
} safe_state_phase_t;

typedef struct {
    safe_state_phase_t phase;
    uint32_t ticks;      /* of this span, 0…1023 */
    ab_t before;         /* current at its beginning */
    uint32_t slow_ticks; /* without a large change and with the bus within its limit, 0…2^20 */
} safe_state_t;

/* What is measured in a tick. */
typedef struct {
    ab_t current;    /* −16384…16383, −28379…28379 */
    int32_t bus;     /* 0…32767 */
    int32_t bus_max; /* 1…32766 */
} safe_state_in_t;

/* Open, and nothing is broken. */
void safe_state_reset(safe_state_t *safe);

/*
 * The drive stops to drive in this tick, at no more than this speed, 0…2^30. Faster than
 * cfg->open_speed: short.
 */
void safe_state_leave(safe_state_t *safe, const safe_state_cfg_t *cfg, step_t speed);

/* The power stage has opened the gates by itself. They stay open until safe_state_reset(). */
void safe_state_break(safe_state_t *safe);

/*
 * One tick that drives nothing. A bus above its limit shorts the motor too: a load drives it, and
 * the diodes charge the bus. Returns whether all low sides are to be on, else the gates are to be
 * open.
 */
bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in);

static inline bool safe_state_is_short(const safe_state_t *safe)
{
    return safe->phase == SAFE_STATE_SHORT;
}

#endif
