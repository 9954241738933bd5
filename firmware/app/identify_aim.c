/* SPDX-License-Identifier: MIT */
#include "identify_aim.h"

/* K_p = L/8 per tick: the bandwidth of the current control is 1/8 per tick */
#define LOOP_SHARE (8U)
/* K_i = K_p/40 per tick: the integral is 5 times slower than the bandwidth */
#define SLOW_SHARE (40U)
/* K_i = K_p/10 per tick: the integral is about as quick as the bandwidth */
#define QUICK_SHARE (10U)
#define SOFT_SHARE (256U) /* across a current at rest K_i is another 256 times smaller */
/* across a current at rest K_p is 16 times smaller; K_p and R damp the rotor */
#define SOFT_GAIN_SHARE (16U)
/*
 * smallest continuous current in counts of its converter: a quarter of it is still above the noise
 */
#define COUNTS_LEAST (24)
#define FULL_SCALE (16384)  /* full scale of a current sensor, Q15 of I_b */
#define INTEGRAL_BITS (11U) /* the integral is finer than the output by 11 bits, pi.h */

void identify_aim_current(identify_t *identify, int32_t current)
{
    identify_aim_set(identify, PROBE_CURRENT, current);
    identify_aim_set(identify, PROBE_PULSE_D, 0);
    identify_aim_set(identify, PROBE_PULSE_Q, 0);
}

void identify_aim_window(identify_t *identify, const char *kind, int32_t settle, int32_t ticks)
{
    identify->aim.kind = kind;
    identify->aim.settle = settle;
    identify->aim.ticks = ticks;
}

/*
 * Converts a gain in Q32 to the format of PROBE_GAIN_D. A gain that is too large for this format
 * becomes the largest that fits.
 */
static int32_t gain_word(uint64_t gain_q32)
{
    uint64_t mantissa = gain_q32;
    uint32_t shift = 32U;
    uint32_t word;

    while ((shift > 30U) || ((mantissa > (uint64_t)FX_Q15_MAX) && (shift > 1U))) {
        mantissa >>= 1U;
        shift--;
    }
    if (mantissa > (uint64_t)FX_Q15_MAX) {
        mantissa = (uint64_t)FX_Q15_MAX;
    }
    word = (shift << 16U) | (uint32_t)mantissa;
    return fx_signed(word);
}

void identify_aim_gains(identify_t *identify, identify_gains_t gains)
{
    const bool soft = gains == IDENTIFY_GAINS_SOFT;
    const uint32_t share = (gains == IDENTIFY_GAINS_QUICK) ? QUICK_SHARE : SLOW_SHARE;
    const uint64_t kp_q32 =
        ((uint64_t)fx_unsigned(identify->rest.inductance_q16) << 16U) / (uint64_t)LOOP_SHARE;
    const uint64_t ki_q32 = (kp_q32 << INTEGRAL_BITS) / (uint64_t)share;

    identify_aim_set(identify, PROBE_GAIN_D, gain_word(kp_q32));
    identify_aim_set(identify, PROBE_INTEGRAL_D, gain_word(ki_q32));
    identify_aim_set(identify, PROBE_GAIN_Q,
                     gain_word(soft ? (kp_q32 / (uint64_t)SOFT_GAIN_SHARE) : kp_q32));
    identify_aim_set(identify, PROBE_INTEGRAL_Q,
                     gain_word(soft ? (ki_q32 / (uint64_t)SOFT_SHARE) : ki_q32));
}

void identify_aim_phase(identify_t *identify, identify_phase_t phase)
{
    identify->phase = phase;
    identify->step = 0U;
}

void identify_aim_refusal_of(identify_t *identify, const char *why, const char *detail)
{
    if (identify->phase != IDENTIFY_HALL) {
        identify->why = why;
        identify->detail = detail;
    }
    identify_aim_phase(identify, IDENTIFY_ENDS);
}

void identify_aim_refusal(identify_t *identify, const char *why)
{
    identify_aim_refusal_of(identify, why, "");
}

bool identify_aim_is_enough(identify_t *identify, const char *why)
{
    const int32_t zero = fx_max((int32_t)identify->about->current_zero_count, 1);
    const int32_t least = (COUNTS_LEAST * FULL_SCALE) / zero;
    const bool enough = identify_aim_continuous(identify) >= least;

    if (!enough) {
        identify->needed = least;
        identify_aim_refusal(identify, why);
    }
    return enough;
}
