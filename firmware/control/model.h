/* SPDX-License-Identifier: MIT */
/*
 * The motor model in force: the configured values of resistance, inductance L_d, saliency L_q/L_d and magnet flux, each
 * corrected by the drive's measurements.
 *
 * A correction is a ratio to the configured value, limited to 1 ± limit_q14, that of the saliency to a factor of
 * 1 + limit_q14 either way. A limit of 0 switches it off. All act on the weights of the observer, but not on its feedback f,
 * and on the feed-forward of both current loops; L_d and L_q also on the gains in RUN, whose bandwidth stays. Corrected
 * numbers are rounded down and saturate at the ends of their formats.
 *
 * A saliency within 1/32 of the configured one counts as that: the gains of two current sensors differ by up to 2 %, and
 * the rest is the measurement's noise. So a motor without saliency stays one, and the observer needs no product for it.
 *
 * Flux: at speed the static error e' of the observer along d is the flux error (φ̂ − φ)/L_d. An integrator removes it.
 */
#ifndef MODEL_H
#define MODEL_H

#include "current_loop.h"
#include "nn_observer.h"

#include <stdint.h>

#define MODEL_RATIO_ONE (16384) /* Q14 */

typedef struct {
    int32_t resistance_limit_q14; /* limit of |ratio − 1|, 0…15000; 0: off */
    int32_t inductance_limit_q14; /* 0…8192 */
    int32_t saliency_limit_q14;   /* 0…16384 */
    int32_t flux_limit_q14;       /* 0…8192 */
    int32_t flux_rate; /* change of the Q30 ratio per slow period = −e'_d · flux_rate, 0…32767 */
    step_t flux_speed_min; /* the flux is corrected from this speed on, 0…2^29 */
} model_cfg_t;

typedef struct {
    nn_observer_cfg_t observer;
    current_loop_cfg_t run_loop;  /* of RUN */
    current_loop_cfg_t hold_loop; /* of an imposed current */
    int32_t resistance_q14;       /* ratios to the configured values */
    int32_t inductance_q14;
    int32_t inductance_inverse_q14;
    int32_t saliency_q14;
    int32_t flux_q30;
} model_t;

/* The configured values: parts of drive_cfg_t. */
typedef struct {
    const nn_observer_cfg_t *observer;
    const current_loop_cfg_t *run_loop;
    const current_loop_cfg_t *hold_loop;
} model_nominal_t;

#define MODEL_UNKNOWN (-1)

/* What was measured. */
typedef struct {
    int32_t resistance_q13; /* U_b/I_b, 1…32767; MODEL_UNKNOWN: what is in force stays */
    int32_t inductance_q14; /* L_d as a ratio to the configured one, 1…32767 */
    int32_t saliency_q13;   /* L_q/L_d, 1…32767; MODEL_UNKNOWN: the configured one stays */
} model_measured_t;

/* All ratios 1. */
void model_reset(model_t *model, const model_nominal_t *nominal);

/* Take over what was measured. The corrections are limited as configured. Six divisions at most, so not in every tick. */
void model_set(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
               const model_measured_t *measured);

/* Correct the flux. Once per slow period. error_d: e'_d of the observer, Q15 of I_b, ±8192. */
void model_track_flux(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                      int32_t error_d, step_t speed);

#endif
