/*
 * Space-vector modulator with bus-voltage compensation.
 *
 * A voltage demand is divided by the measured bus voltage (by a reciprocal that one Newton step a tick
 * keeps up to date: no division), turned into three duties with half the sum of the largest and the
 * smallest phase removed (the symmetric space-vector pattern), and rounded to timer counts.
 *
 * Voltages Q15 of U_b; ratios "of the bus" are Q15 with 1 = the bus voltage. Pure, total within the
 * ranges.
 */
#ifndef MODULATOR_H
#define MODULATOR_H

#include "transforms.h"

#include <stdint.h>

typedef struct {
    int32_t timer_counts; /* compare value of duty 1, 1…32767 */
    int32_t
        ratio_max_q15; /* largest |v| / bus: 1/√3 less what dead time and sampling need, ≤ 18918 */
    int32_t inverse_max_q12; /* 1 / smallest bus voltage worked with, 4096…32767 */
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

/* Voltage (Q15 of U_b, ±32767) to a ratio of the bus (Q15), saturated to 16 bits, rounded down. */
dq_t modulator_ratio(const modulator_t *mod, dq_t voltage);

/* A ratio vector, |α|, |β| ≤ 46341, to compare values; duties are clamped to 0…1, counts rounded. */
compare_t modulator_compare(const modulator_cfg_t *cfg, ab_t ratio);

#endif
