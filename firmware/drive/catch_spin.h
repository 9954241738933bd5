/* SPDX-License-Identifier: MIT */
/*
 * Is the rotor already turning, how fast and where?
 *
 * With all low sides on and no high side, the back-EMF drives a current through the shorted windings:
 * after a time t the current is −e·t/L, and e = jωφ·e^{jθ}. Two such pulses, each ended at a current that can
 * be measured, give two directions of e; the angle between them over the time between them is the speed with its
 * sign, and the direction less a quarter turn is the rotor. No leg switches meanwhile, so dead time plays no part. A
 * speed that does not fit the size of the current is noise: the rotor stands, or is slow enough to be pulled in.
 *
 * What flows from before has to end first, through the diodes of the open bridge.
 *
 * Before the first high side is driven, its bootstrap supply wants a low side that is on for longer than two pulses. That
 * would brake a rotor that turns: only behind one found to be standing do the low sides stay on.
 *
 * Pure, total. Call catch_spin_step once a control tick in place of current control, compare values all 0.
 */
#ifndef CATCH_SPIN_H
#define CATCH_SPIN_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/* A current below 2^-this of that at which a pulse ends is none; judged is what is above it. */
#define CATCH_SPIN_QUIET_LOG2 (2U)

typedef struct {
    int32_t current;       /* a pulse ends above this current, Q15 of I_b, 1…16384 */
    uint32_t wait_ticks;   /* a current that has not ended after so many ticks never will, 1…2^20 */
    uint32_t pulse_ticks;  /* or after so many ticks, 1…16 */
    uint32_t gap_factor;   /* the pause is so many times as long as the pulse, 1…16 … */
    uint32_t pause_max;    /* … but not longer than so many ticks, 1…256 */
    int32_t emf_current;   /* φ/L_d·ω·T: current for a speed, Q15 of I_b in a tick = speed ·
                              emf_current / 2^(16 + emf_shift), 1…32767 */
    uint32_t emf_shift;    /* 0…30 */
    uint32_t charge_ticks; /* at a standing rotor the low sides stay on for so many ticks, 0…2^20 */
} catch_spin_cfg_t;

typedef enum {
    CATCH_SPIN_BUSY = 0,
    CATCH_SPIN_STANDING, /* at rest, or too slow to tell */
    CATCH_SPIN_TURNING,
    CATCH_SPIN_LIVE /* a current does not end */
} catch_spin_result_t;

typedef enum {
    CATCH_SPIN_PRELOAD = 0, /* until nothing flows; compare values written now act a tick later */
    CATCH_SPIN_FIRST_PULSE,
    CATCH_SPIN_PAUSE,
    CATCH_SPIN_SECOND_PULSE,
    CATCH_SPIN_CHARGE /* of the bootstrap supplies */
} catch_spin_phase_t;

typedef struct {
    uint32_t tick; /* of the phase */
    catch_spin_phase_t phase;
    uint32_t length; /* of the pulses */
    ab_t first;      /* current at the end of the first pulse */
    bool gates;      /* to be enabled in this tick */
    step_t speed;    /* found, when TURNING */
    angle_t angle;   /* of the rotor at the end of the second pulse */
} catch_spin_t;

/* Begin. */
void catch_spin_reset(catch_spin_t *spin);

/*
 * One tick. current: measured at this instant, Q15 of I_b, |α|, |β| ≤ 65535. Sets `gates`.
 *
 * Returns BUSY until the result is known. The last tick of the second pulse returns TURNING or STANDING; it computes two
 * arctangents, a square root and a division. If the rotor stands and there is a charge, the last tick of the charge returns
 * STANDING instead. `gates` is still set in the tick that returns either. The caller opens the gates in that tick, unless
 * current control takes a turning rotor over. LIVE comes from the first phase, before the gates are enabled.
 */
catch_spin_result_t catch_spin_step(catch_spin_t *spin, const catch_spin_cfg_t *cfg, ab_t current);

#endif
