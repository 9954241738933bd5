/* SPDX-License-Identifier: MIT */
/*
 * The motor model in force: the configured values of resistance, inductance L_d, saliency L_q/L_d
 * and magnet flux, each corrected by the drive's measurements.
 *
 * A correction is a ratio to the configured value. It is limited to 1 ± limit_q14; the ratio of the
 * saliency is limited to 1/(1 + limit_q14)…1 + limit_q14. A limit of 0 switches the correction off.
 * All corrections act on the weights of the observer, but not on its feedback f, and on the
 * feed-forward of both current loops. L_d and L_q also act on the gains in RUN, so that the
 * bandwidth stays. Corrected numbers are rounded down and saturate at the ends of their formats.
 *
 * A measured saliency within 1/32 of the configured one counts as equal to it: the gains of two
 * current sensors differ by up to 2 %, and noise adds to that. So a motor that is configured
 * without saliency stays without saliency, and the observer saves the product for it.
 *
 * Pace: at low speed the unknown part of the voltage is larger relative to the EMF, and its ripple
 * is slower. So below pace.full_speed the gains in force are the configured ones times speed /
 * full_speed. Below kappa.full_speed κ is multiplied by a second share, speed / kappa.full_speed:
 * at high speed the ripple is faster than the estimate, and a larger κ shortens the lag.
 *
 * Flux: at speed the static error e' of the observer along d is the flux error (φ̂ − φ)/L_d. An
 * integrator removes it.
 */
#ifndef MODEL_H
#define MODEL_H

#include "current_loop.h"
#include "nn_observer.h"

#include <stdbool.h>
#include <stdint.h>

#define MODEL_RATIO_ONE (16384) /* Q14 */

/* Share of a configured gain that is in force: speed / full_speed, at most 1. */
typedef struct {
    step_t full_speed; /* the share is 1 from this speed on, 0…2^28; 0: it is always 1 */
    uint32_t shift;    /* full_speed >> shift is below 2^14, 0…15 */
    int32_t gain;      /* 2^28 / (full_speed >> shift), 0…32767 */
    int32_t least_q14; /* the smallest share, 0…16384 */
} gain_share_cfg_t;

typedef struct {
    int32_t resistance_limit_q14; /* limit of |ratio − 1| for R, 0…15000; 0: R is not corrected */
    int32_t inductance_limit_q14; /* the same for L_d, 0…8192 */
    int32_t saliency_limit_q14;   /* the ratio is within 1/(1 + limit)…1 + limit, 0…16384 */
    int32_t flux_limit_q14;       /* limit of |ratio − 1| for φ, 0…8192 */
    int32_t flux_rate; /* change of the Q30 ratio per slow period = −e'_d · flux_rate, 0…32767 */
    step_t flux_speed_min; /* the flux is corrected from this speed on, 0…2^29 */
    gain_share_cfg_t pace;
    gain_share_cfg_t kappa; /* second share, for κ only */
} model_cfg_t;

typedef struct {
    nn_observer_cfg_t observer;
    current_loop_cfg_t run_loop;  /* current loop of RUN */
    current_loop_cfg_t hold_loop; /* current loop of an imposed current */
    /* R in force / configured R */
    int32_t resistance_q14;
    int32_t inductance_q14;         /* L_d in force / configured L_d */
    int32_t inductance_inverse_q14; /* reciprocal of inductance_q14 */
    int32_t saliency_q14;           /* L_q/L_d in force / configured L_q/L_d */
    int32_t flux_q30;               /* φ in force / configured φ */
    int32_t pace_q14;               /* share of all gains that is in force */
    int32_t kappa_q14;              /* second share, for κ only */
    /* check words, see model_holds() */
    uint32_t check_observer; /* check word of the observer's weights and of the ratios */
    uint32_t check_loops;    /* check word of the loops */
    uint32_t check_gains;    /* check word of the shares and of the gains that they change */
} model_t;

/* The configured values: parts of drive_cfg_t. */
typedef struct {
    const nn_observer_cfg_t *observer;
    const current_loop_cfg_t *run_loop;
    const current_loop_cfg_t *hold_loop;
} model_nominal_t;

#define MODEL_UNKNOWN (-1)

/* Measured values. */
typedef struct {
    int32_t resistance_q13; /* U_b/I_b, 1…32767; MODEL_UNKNOWN: R in force stays */
    int32_t inductance_q14; /* L_d / configured L_d, 1…32767 */
    int32_t saliency_q13;   /* L_q/L_d, 1…32767; MODEL_UNKNOWN: the configured saliency is used */
} model_measured_t;

/* Sets the configured values: all ratios and shares are 1. */
void model_reset(model_t *model, const model_nominal_t *nominal);

/*
 * Take over measured values. The corrections are limited as configured. Six divisions at most, so
 * not in every tick.
 */
void model_set(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
               const model_measured_t *measured);

/*
 * Take over other configured values. The measured ratios stay, within the new limits; the shares of
 * the gains stay too. Four divisions at most. Control interrupt only.
 */
void model_change(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal);

/* Correct the flux. Once per slow period. error_d: e'_d of the observer, Q15 of I_b, ±8192. */
void model_track_flux(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                      int32_t error_d, step_t speed);

/*
 * Returns L_q in force / configured L_q, Q14, 4096…49151. This range holds for ratios of L_d within
 * ½…1.5 and of the saliency within ½…2.
 */
static inline int32_t model_ratio_q_q14(const model_t *model)
{
    return fx_asr(model->inductance_q14 * model->saliency_q14, 14U);
}

/* Whether both shares are 1 and stay 1 at this speed. magnitude: |speed|, 0…2^30. */
static inline bool model_is_whole(const model_t *model, const model_cfg_t *cfg, step_t magnitude)
{
    return (magnitude >= cfg->pace.full_speed) && (magnitude >= cfg->kappa.full_speed) &&
           ((model->pace_q14 + model->kappa_q14) == (2 * MODEL_RATIO_ONE));
}

/* Parts of the model that are checked one at a time. */
typedef enum {
    MODEL_PART_OBSERVER = 0, /* the observer's weights, and the ratios */
    MODEL_PART_LOOPS,
    MODEL_PART_GAINS, /* the shares, and the gains that they change */
    MODEL_PART_FLUX   /* words that are computed from the ratio of the flux */
} model_part_t;

/*
 * Returns true while the words of a part are as they were written last. Returns false when a bit
 * has flipped by itself in one of these words or in their check word. The words of MODEL_PART_FLUX
 * have no check word: they are computed again and compared. Some 40 to 60 instructions on a
 * Cortex-M0+. Control interrupt only.
 */
bool model_holds(model_t *model, const model_nominal_t *nominal, model_part_t part);

/*
 * Applies the shares of this speed to η, κ_p, the limit of ρ and the gains of the current loop in
 * RUN. Once per slow period; if no share has changed it writes nothing. speed: ±2^30.
 */
void model_pace(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                step_t speed);

#endif
