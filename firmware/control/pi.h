/* SPDX-License-Identifier: MIT */
/*
 * PI controller with limited output and anti-windup, paper B (28)–(30) in backward-difference form:
 *     I(k) = I(k−1) + K_i·T·e(k),   u(k) = K_p·e(k) + I(k) + feed-forward, limited to ±limit
 *
 * Signals are Q15 per unit. The integral is Q26 (11 bits finer than the output), so that an error
 * of one LSB is integrated if K_i·T is at least 2^-11. Pure, total within the ranges; control
 * interrupt only.
 */
#ifndef PI_H
#define PI_H

#include "fx.h"

#include <stdint.h>

/* Gain = mantissa / 2^shift. The configuration keeps the mantissas near full scale. */
typedef struct {
    /* proportional gain, −32767…32767; a negative gain reduces the plant's own damping */
    int32_t kp;
    int32_t ki;        /* integral gain × period, 0…32767 */
    uint32_t kp_shift; /* 1…30 */
    uint32_t ki_shift; /* gain = ki / 2^(ki_shift + 11), for the 11 bits of the integral, 1…30 */
} pi_cfg_t;

typedef struct {
    int32_t integral_q26;
} pi_t;

#define PI_INTEGRAL_BITS (11U) /* fractional bits of the integral beyond those of the output */

/*
 * The next three functions are the parts of pi_step(), for a loop whose limit is not simply ±limit.
 * Control tick.
 */

/* Returns the integral after this sample, Q26, saturated at ±1. |error| ≤ 65535. Pure. */
static inline int32_t pi_integral(const pi_t *pi, const pi_cfg_t *cfg, int32_t error)
{
    return fx_sat27(pi->integral_q26 + fx_asr(error * cfg->ki, cfg->ki_shift));
}

/*
 * Returns proportional part and integral, Q15, each rounded down. |error| ≤ 65535. u is this sum
 * plus a feed-forward. Pure.
 */
static inline int32_t pi_sum(const pi_cfg_t *cfg, int32_t error, int32_t integral_q26)
{
    return fx_asr(error * cfg->kp, cfg->kp_shift) + fx_asr(integral_q26, PI_INTEGRAL_BITS);
}

/*
 * Returns u within ±limit, 0…32767. Stores integral_q26. While u exceeds a limit, the integral is
 * not moved further in that direction. |u| < 2^30.
 */
int32_t pi_limit(pi_t *pi, int32_t integral_q26, int32_t u, int32_t limit);

/*
 * Set the integral so that the next output starts at `output` (Q15, −32768…32767) with zero error.
 */
void pi_reset(pi_t *pi, int32_t output);

/* Returns the output at zero error, which is the integral, Q15, rounded down. */
int32_t pi_output(const pi_t *pi);

/*
 * One sample. error: |error| ≤ 65535; feed_forward: |feed_forward| ≤ 2^19; limit: 0…32767, all Q15.
 * Returns u within ±limit, rounded down. Anti-windup: while the output is at a limit, the integral
 * does not move further in that direction. The integral saturates at ±1.
 */
int32_t pi_step(pi_t *pi, const pi_cfg_t *cfg, int32_t error, int32_t feed_forward, int32_t limit);

/*
 * Tell the controller that only u − excess of its last output was applied, as when the voltage
 * circle limits one axis. The integral is reduced by the excess and saturates at ±1. excess: Q15,
 * ±32767.
 */
void pi_unwind(pi_t *pi, int32_t excess);

#endif
