/* SPDX-License-Identifier: MIT */
/*
 * Space-vector modulator with bus-voltage compensation.
 *
 * A voltage demand is divided by the measured bus voltage (by a reciprocal that one Newton step a tick
 * keeps up to date: no division), turned into three duties with half the sum of the largest and the
 * smallest phase removed (the symmetric space-vector pattern), and rounded to timer counts.
 *
 * Dead time and device drop. In a leg whose current i flows into the motor, each period loses the dead time
 * t_d of its high side and the drop v_d of the conducting device; with i < 0 it gains both. The duty is
 * given back t_d/T + v_d/u_bus in the direction of the current expected for the period. Near
 * zero the current's ripple decides: the two edges of a leg lie symmetrically in the period, where the ripple has
 * opposite signs, and while |i| is below its size they cancel. With s the difference of the largest and the
 * smallest ratio and u the ratio of the leg, the ripple at the edges of the leg in the middle is
 *     r = u_bus·T/(12·L)·(s − 9·u²)
 * and little more than zero in the other two. So nothing is given back for |i| < r, all of it a few counts of the
 * converter above, and in proportion between: a current about zero does not make the voltage chatter.
 *
 * Voltages Q15 of U_b; ratios "of the bus" are Q15 with 1 = the bus voltage. Pure, total within the
 * ranges.
 */
#ifndef MODULATOR_H
#define MODULATOR_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t timer_counts; /* compare value of duty 1, 1…32767 */
    int32_t
        ratio_max_q15; /* largest |v| / bus: 1/√3 less what dead time and sampling need, ≤ 18918 */
    int32_t inverse_max_q12; /* 1 / smallest bus voltage worked with, 4096…32767 */
    int32_t dead_time_q15;   /* t_d/T, 0…8192 */
    int32_t drop_q15;        /* v_d, Q15 of U_b, 0…2048 */
    int32_t ripple_q15;      /* u_bus·T/(12·L), Q15 of I_b, 0…16384 */
    int32_t edge_slope; /* 1 / the current from none to all, in Q15 of I_b times 2^-15, 1…32767 */
} modulator_cfg_t;

typedef struct {
    int32_t inverse_bus_q12; /* 1 / bus voltage, 1…inverse_max */
} modulator_t;

typedef struct {
    uint16_t phase[3]; /* 0…timer_counts */
} compare_t;

/* Start the reciprocal at its lower bound, from where it converges for every bus voltage. */
void modulator_reset(modulator_t *mod);

/*
 * One Newton step r ← r·(2 − r·bus). From the reset it has settled after 8 ticks for any bus above
 * 1/8, to within 2 LSB (2^-11); a change of the bus by a share x in one tick leaves a share x² for that
 * tick. bus: Q15 of U_b, 0…32767.
 */
void modulator_track_bus(modulator_t *mod, const modulator_cfg_t *cfg, int32_t bus);

/* Radius of the voltage circle at this bus voltage, Q15 of U_b. */
int32_t modulator_limit(const modulator_cfg_t *cfg, int32_t bus);

/* Voltage (Q15 of U_b, ±65535) to a ratio of the bus (Q15), saturated to 16 bits, rounded down. */
dq_t modulator_ratio(const modulator_t *mod, dq_t voltage);

/* Whether anything is given back. If not, nothing has to be known of the current. */
static inline bool modulator_compensates(const modulator_cfg_t *cfg)
{
    return (cfg->dead_time_q15 != 0) || (cfg->drop_q15 != 0);
}

/*
 * A ratio vector, |α|, |β| ≤ 46341, to compare values; duties are clamped to 0…1, counts rounded.
 * current: expected in the middle of the period, Q15 of I_b, |α|, |β| ≤ 46341; NULL: nothing is given back.
 */
void modulator_compare(const modulator_t *mod, const modulator_cfg_t *cfg, ab_t ratio,
                       const ab_t *current, compare_t *out);

#endif
