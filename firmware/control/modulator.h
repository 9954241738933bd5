/* SPDX-License-Identifier: MIT */
/*
 * Space-vector modulator with bus-voltage compensation.
 *
 * The modulator divides a voltage demand by the measured bus voltage and turns it into three
 * duties. It subtracts half the sum of the largest and the smallest phase voltage (the symmetric
 * space-vector pattern) and rounds to timer counts. The division is a product with the reciprocal
 * of the bus voltage, which one Newton step a tick keeps up to date.
 *
 * Compensation of dead time and device drop. While the current i of a leg flows into the motor, the
 * leg loses in each period the dead time t_d of its high side and the voltage drop v_d of the
 * conducting device. With i < 0 it gains both. The compensation adds t_d/T + v_d/u_bus to the duty,
 * with the sign of the current that is expected for the period.
 *
 * Near zero current the ripple of the current decides. The two edges of a leg lie symmetrically in
 * the period, where the ripple has opposite signs. So the effects of both edges cancel while |i| is
 * smaller than the ripple. Let u be the ratio of a leg, and s the largest less the smallest of the
 * three ratios. The ripple at the edges of the leg with the middle ratio is
 *     r = u_bus·T/(12·L)·(s − 9·u²)
 * and nearly zero for the other two legs. The compensation is zero for |i| < r.
 *
 * Above r, the capacitance C of the leg decides. In the dead time the current has to charge C. Up
 * to the knee, i_k = C·u_bus/t_d, it charges C only in part, and the leg loses the share i/(2·i_k)
 * of t_d. Above the knee it loses the share 1 − i_k/(2·i). With z = (|i| − r)/i_e, at most 1, the
 * compensation takes the share
 *     s(z) = z·(2 − z)
 * of the whole compensation. For i_e = 3.5·i_k this share differs from the real loss by
 * −0.01…+0.14. i_e is at least a few counts of the current sensor, so that a current near zero does
 * not make the voltage chatter.
 *
 * Voltages are Q15 of U_b. Ratios "of the bus" are Q15 with 1 = the bus voltage. Pure, total within
 * the ranges.
 */
#ifndef MODULATOR_H
#define MODULATOR_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t timer_counts; /* compare value of duty 1, 1…32767 */
    /* largest |v| / bus: 1/√3 less the share that dead time and sampling need, ≤ 18918 */
    int32_t ratio_max_q15;
    int32_t dead_time_q15; /* dead time t_d/T, 0…8192 */
    /* a measurement corrects t_d/T by at most this, 0…4096; 0: it does not */
    int32_t dead_time_band_q15;
    int32_t drop_q15;   /* device drop v_d, Q15 of U_b, 0…2048 */
    int32_t ripple_q15; /* factor u_bus·T/(12·L) of r, Q15 of I_b, 0…16384 */
    /*
     * The compensation rises from zero to the whole over the current i_e = I_b / edge_slope,
     * 1…32767.
     */
    int32_t edge_slope;
} modulator_cfg_t;

/* the bus voltage is compensated only down to 1/9 of U_b */
#define MODULATOR_INVERSE_MAX_Q12 (36863)

typedef struct {
    /* t_d/T in force: configured, or corrected by a measurement, 0…12288 */
    int32_t dead_time_q15;
    int32_t inverse_bus_q12; /* 1 / bus voltage, 4096…MODULATOR_INVERSE_MAX_Q12 */
} modulator_t;

typedef struct {
    uint16_t phase[3]; /* compare values of phases a, b, c, 0…timer_counts */
} compare_t;

/*
 * Sets the configured dead time. Sets the reciprocal of the bus voltage to its lower bound, from
 * where it converges for every bus voltage.
 */
void modulator_reset(modulator_t *mod, const modulator_cfg_t *cfg);

/*
 * Take over another configuration. A measured correction of the dead time stays, within the new
 * band. Control interrupt only.
 */
void modulator_change(modulator_t *mod, const modulator_cfg_t *from, const modulator_cfg_t *to);

/*
 * Correct the dead time by a measurement. lost: the voltage that the legs took in excess of the
 * compensation in force, along a current vector on the axis of phase a, Q15 of U_b, ±16384. With
 * such a vector the legs b and c carry half of the current of leg a, so that lost =
 * 4/3·Δt_d/T·u_bus. The currents of all legs have to be well above ripple and knee. Device drop
 * that the configuration does not know counts as dead time. A change by up to 1/64 of the dead time
 * in force is ignored, because repeated measurements differ by as much. Rounded down, limited to
 * the configured band. Call once when an alignment ends. Returns the change of t_d/T, Q15: along
 * such a vector the compensation adds 4/3 of this share of the bus voltage from now on.
 */
int32_t modulator_correct(modulator_t *mod, const modulator_cfg_t *cfg, int32_t lost);

/*
 * Extrapolates the bus voltage by its last change to the middle of the period in which the present
 * demand will act, 1.5 periods ahead. Bus voltages: Q15 of U_b, 0…32767; so is the result, rounded
 * down and saturated.
 */
static inline int32_t modulator_bus_ahead(int32_t before, int32_t now)
{
    const int32_t change = now - before;

    return fx_usat15(now + change + fx_asr(change, 1U));
}

/*
 * One Newton step r ← r·(2 − r·bus). bus: Q15 of U_b, 0…32767. For any bus above 1/8 the reciprocal
 * has settled to within 2 LSB (2^-11) 8 ticks after the reset. When `bus` changes by a share x in
 * one tick, the reciprocal has a relative error of x² in that tick. The voltage circle is computed
 * from the present bus voltage. On a falling bus a demand at the edge of the circle exceeds
 * ratio_max by the share by which the bus falls until the demand acts.
 */
void modulator_track_bus(modulator_t *mod, int32_t bus);

/* Returns the radius of the voltage circle at this bus voltage, Q15 of U_b. */
int32_t modulator_limit(const modulator_cfg_t *cfg, int32_t bus);

/*
 * Converts a voltage (Q15 of U_b, ±32768) to a ratio of the bus (Q15). Saturated to 16 bits,
 * rounded down.
 */
dq_t modulator_ratio(const modulator_t *mod, dq_t voltage);

/* Whether dead time or drop is compensated. If not, modulator_compare() is enough. */
static inline bool modulator_compensates(const modulator_cfg_t *cfg)
{
    return (cfg->dead_time_q15 | cfg->drop_q15) != 0;
}

/*
 * Converts a ratio vector, |α|, |β| ≤ 46341, to compare values. Duties are clamped to 0…1, counts
 * are rounded.
 */
void modulator_compare(const modulator_cfg_t *cfg, ab_t ratio, compare_t *out);

/*
 * As modulator_compare(), with compensation of dead time and drop. current: the current that is
 * expected in the middle of the period, Q15 of I_b, |α|, |β| ≤ 46341.
 */
void modulator_compare_compensated(const modulator_t *mod, const modulator_cfg_t *cfg, ab_t ratio,
                                   ab_t current, compare_t *out);

#endif
