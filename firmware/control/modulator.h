/*
 * Space-vector modulator with bus-voltage compensation.
 *
 * A voltage demand is divided by the measured bus voltage (by a reciprocal that one Newton step a tick
 * keeps up to date: no division), turned into three duties with half the common-mode of the largest
 * and smallest phase removed (the symmetric space-vector pattern), and rounded to timer counts.
 *
 * Voltages Q15 of U_b; ratios "of the bus" are Q15 with 1 = the bus voltage. Pure, total.
 */
#ifndef MODULATOR_H
#define MODULATOR_H

#include "transforms.h"

#include <stdint.h>

typedef struct {
    uint16_t timer_counts;   /* compare value of duty 1, 1…32767 */
    int16_t ratio_max_q15;   /* largest |v| / bus: 1/√3 less what dead time and sampling need */
    int32_t inverse_max_q27; /* 1 / smallest bus voltage worked with, < 8 */
} modulator_cfg_t;

typedef struct {
    int32_t inverse_bus_q27; /* 1 / bus voltage, 1…inverse_max */
} modulator_t;

typedef struct {
    uint16_t phase[3]; /* 0…timer_counts */
} compare_t;

/* Start the reciprocal at its lower bound, from where it converges for every bus voltage. */
void modulator_reset(modulator_t *mod);

/*
 * One Newton step r ← r·(2 − r·bus). From the reset it needs 2·log2(1/bus) + 4 ticks; it follows a
 * change of 5 % a tick within 0.3 %. bus: Q15 of U_b, 0…32767.
 */
void modulator_track_bus(modulator_t *mod, const modulator_cfg_t *cfg, int16_t bus);

/* Radius of the voltage circle at this bus voltage, Q15 of U_b. */
int16_t modulator_limit(const modulator_cfg_t *cfg, int16_t bus);

/* Voltage (Q15 of U_b) to a ratio of the bus (Q15), saturated, rounded down. */
dq_t modulator_ratio(const modulator_t *mod, dq_t voltage);

/* A ratio vector to three compare values; duties are clamped to 0…1, counts rounded to nearest. */
compare_t modulator_compare(const modulator_cfg_t *cfg, ab_t ratio);

#endif
