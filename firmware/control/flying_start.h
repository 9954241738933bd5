/* SPDX-License-Identifier: MIT */
/*
 * Flying start: finds out whether the rotor turns already, how fast, and at which angle it is.
 *
 * All low sides are switched on, and no high side is. The back-EMF then drives a current through
 * the shorted windings: after a time t the current is −e·t/L with e = jωφ·e^{jθ}. A pulse ends when
 * the current is large enough to measure. Two pulses give two directions of e. The angle between
 * them divided by the time between them is the speed with its sign; the second direction less a
 * quarter turn is the angle of the rotor. No leg switches during a pulse, so dead time has no
 * effect. When the speed does not fit the magnitude of the current, the measurement is noise: the
 * rotor stands, or it is slow enough to be pulled in.
 *
 * Speed and current together give φ/L: the current of a pulse is φ/L_q times the angle by which the
 * rotor turns in it, less the part that R takes. The configured φ is more certain than the
 * configured L, so a deviation is taken for an error of L. A rotor that turns by less than 30° from
 * pulse to pulse gives no L: the noise of the two directions is then as large as the possible error
 * of L.
 *
 * Before the first pulse, current that still flows has to decay through the diodes of the open
 * bridge.
 *
 * A bootstrap supply has to be charged before its first high side is driven. That needs a low side
 * that is on for longer than two pulses, which would brake a rotor that turns. So the low sides
 * stay on only when the rotor is found to stand.
 *
 * Pure, total. Call flying_start_step once per control tick in place of current control, with all
 * compare values 0.
 */
#ifndef FLYING_START_H
#define FLYING_START_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * A current below 2^-FLYING_START_QUIET_LOG2 of the current at which a pulse ends counts as zero.
 */
#define FLYING_START_QUIET_LOG2 (2U)

typedef struct {
    int32_t current; /* a pulse ends above this current, Q15 of I_b, 1…16384 */
    /* if the current has not decayed after this many ticks, the result is LIVE, 1…2^20 */
    uint32_t wait_ticks;
    uint32_t pulse_ticks; /* a pulse ends after this many ticks at the latest, 1…16 */
    uint32_t gap_factor;  /* the pause lasts this many times as long as a pulse, 1…64 */
    uint32_t pause_max;   /* longest pause in ticks, 1…256 */
    /*
     * Gives the current after the first tick of a pulse, φ/L_q·ω·T·(1 − exp(−a))/a with a =
     * T·R/L_q. In Q15 of I_b it is speed · emf_current / 2^(16 + emf_shift). 1…32767
     */
    int32_t emf_current;
    uint32_t emf_shift; /* 0…30 */
    /* a tick of the short circuit reduces a current by this share, 1 − exp(−a), 0…32767 */
    int32_t decay_q15;
    /* ticks of the bootstrap charge when the rotor stands, 0…2^20; 0: no charge */
    uint32_t charge_ticks;
} flying_start_cfg_t;

typedef enum {
    FLYING_START_BUSY = 0,
    FLYING_START_STANDING, /* the rotor rests, or turns too slowly to be measured */
    FLYING_START_TURNING,
    FLYING_START_LIVE /* the current has not decayed; its vector turns with `speed` */
} flying_start_result_t;

typedef enum {
    /* waits until the current is zero and the new compare values act: two ticks at least */
    FLYING_START_PRELOAD = 0,
    FLYING_START_FIRST_PULSE,
    FLYING_START_PAUSE,
    FLYING_START_SECOND_PULSE,
    FLYING_START_CHARGE /* the bootstrap supplies are charged */
} flying_start_phase_t;

typedef struct {
    uint32_t tick; /* ticks since the phase began */
    flying_start_phase_t phase;
    uint32_t length; /* ticks of a pulse */
    /* In PRELOAD: current of the tick before. Later: current at the end of the first pulse. */
    ab_t first;
    bool gates; /* the gates are enabled in this tick */
    /* Valid when the result is TURNING, the speed also when it is LIVE: */
    step_t speed;           /* measured speed */
    angle_t angle;          /* angle of the rotor at the end of the second pulse */
    int32_t inductance_q14; /* L_q / configured L_q if φ is as configured, 1…32767; 0: not known */
} flying_start_t;

/* Starts with PRELOAD. */
void flying_start_reset(flying_start_t *start);

/*
 * One tick. current: measured at this instant, Q15 of I_b, |α|, |β| ≤ 65535. Sets `gates`.
 *
 * Returns BUSY until the result is known. The last tick of the second pulse returns TURNING or
 * STANDING; it computes up to three arctangents, two square roots and two divisions. When the rotor
 * stands and charge_ticks is not 0, the last tick of the charge returns STANDING instead. `gates`
 * is still set in the tick that returns TURNING or STANDING. The caller opens the gates in that
 * tick, unless current control takes over a rotor that turns. LIVE is returned in the first phase
 * only, before the gates are enabled. Each tick of that phase in which a current flows computes a
 * square root, two arctangents and a division.
 */
flying_start_result_t flying_start_step(flying_start_t *start, const flying_start_cfg_t *cfg,
                                        ab_t current);

#endif
