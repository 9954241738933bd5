/* SPDX-License-Identifier: MIT */
/*
 * Torque filter: a low-pass and a notch for the torque current, against the resonance of an elastic
 * shaft.
 *
 * Low-pass:  s(k) = s(k−1) + r·(i(k) − s(k−1))
 *
 * Notch: a vector z turns by θ in a sample. z follows the part of the current that swings at the
 * rate θ. The real part of z is subtracted from the current:
 *     e(k) = i(k) − Re z(k),   z(k+1) = exp(jθ)·(z(k) + μ·e(k)),   out(k) = (1 − μ/2)·e(k)
 * As a transfer function:
 *     (1 − μ/2)·(1 − 2·cosθ·z⁻¹ + z⁻²) / (1 − (2 − μ)·cosθ·z⁻¹ + (1 − μ)·z⁻²)
 * With the sample rate f_s the gain is 0 at the frequency f_s·θ/2π, and 1 at zero and at f_s/2.
 * Half of the power passes at both ends of a band of the width b if μ = 2t/(1 + t), t =
 * tan(π·b/f_s).
 *
 * The notch acts on the difference from the current that it starts with, so a constant current
 * passes from the first sample on. After a step the steady gain is 1 within 2^-10 for |θ| ≥ 2π/256,
 * because sine and cosine are rounded. The states are Q26, 11 bits finer than a current, and
 * products are rounded down. The result is rounded to nearest; the roundings of the states add less
 * than an LSB to it.
 *
 * Currents Q15 of I_b. Pure, total. Call once a slow period, from the control interrupt only.
 */
#ifndef TORQUE_FILTER_H
#define TORQUE_FILTER_H

#include "fx.h"
#include "transforms.h"
#include "trig.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t smooth_rate_q15; /* r of the low-pass, 0…32767; 0: no low-pass */
    int32_t notch_share_q15; /* μ of the notch, 0…32767; 0: no notch */
    sincos_t notch_turn;     /* sine and cosine of θ */
} torque_filter_cfg_t;

typedef struct {
    int32_t origin;     /* current with which the filter started, ±16384 */
    int32_t smooth_q26; /* s of the low-pass, ±2^26 */
    dq_t swing_q26;     /* z of the notch, d: real part, q: imaginary part, ±2^27 */
} torque_filter_t;

/* Whether there is a low-pass or a notch. */
static inline bool torque_filter_acts(const torque_filter_cfg_t *cfg)
{
    return (cfg->smooth_rate_q15 | cfg->notch_share_q15) != 0;
}

/* Start as if the input had always been `current`, ±16384. */
void torque_filter_start(torque_filter_t *filter, int32_t current);

/*
 * One sample. current: ±16384. Returns the filtered current, ±2^18; after a step of the current it
 * may overshoot by a sixth of the step. s saturates at ±1, z at ±2, four times the largest current.
 */
int32_t torque_filter_step(torque_filter_t *filter, const torque_filter_cfg_t *cfg,
                           int32_t current);

#endif
