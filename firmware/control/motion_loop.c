/* SPDX-License-Identifier: MIT */
#include "motion_loop.h"

#include "trig.h"

#include <stdbool.h>

#define Q32_TO_Q16 (65536)
#define Q15_TO_Q26 (2048)
#define HALF_TURN_SHIFT (31U)
#define WHOLE_TURN_SHIFT (32U)
/* from the largest speed backwards to the largest speed forwards */
#define CHANGE_MAX (0x40000000)
/*
 * Limit of a distance in distance units: at least 1.75 braking distances. The softest stop needs (1
 * + 2c) braking distances.
 */
#define DISTANCE_MAX (0x7000U)

#define SHIFT_MAX (31) /* largest shift of fx_asr() */
#define RATIO_ONE_Q17 (131072)
#define RATIO_SHIFT (4U) /* Q17 to Q13 */
#define Q13_TO_Q17 (16)
#define Q15_TO_Q30 (32768)
#define RESPONSE_SHIFT_MAX (30) /* with this shift one LSB gives 2^30, the limit */

void speed_loop_lower(speed_loop_t *loop)
{
    loop->halvings = 1U;
}

void speed_loop_restore(speed_loop_t *loop)
{
    loop->halvings = 0U;
}

void speed_loop_init(speed_loop_t *loop)
{
    *loop = (speed_loop_t){.inertia_q17 = RATIO_ONE_Q17};
}

void speed_loop_change(speed_loop_t *loop, const speed_loop_cfg_t *cfg)
{
    loop->inertia_q17 = fx_clamp(loop->inertia_q17, cfg->inertia_least_q13 * Q13_TO_Q17,
                                 cfg->inertia_most_q13 * Q13_TO_Q17);
}

void speed_loop_reset(speed_loop_t *loop, step_t speed)
{
    pi_reset(&loop->pi, 0);
    loop->reference = speed;
}

void speed_loop_refer(speed_loop_t *loop, step_t reference)
{
    loop->reference = reference;
}

step_t speed_loop_ramp(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t target)
{
    const step_t wanted = fx_clamp(target, -cfg->speed_max, cfg->speed_max);

    return fx_towards(loop->reference, wanted, cfg->ramp);
}

void speed_loop_start(speed_loop_t *loop, step_t reference, int32_t current)
{
    pi_reset(&loop->pi, current);
    loop->reference = reference;
}

/* Returns i_q for a change of the speed in a slow period. */
static int32_t inertia_torque(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t change)
{
    /*@ split cfg->inertia_lift; */
    /* `lifted` saturates at 2^30, which is far beyond the range of the torque. */
    const int32_t largest = fx_asr(CHANGE_MAX, cfg->inertia_lift);
    const uint32_t lift = (uint32_t)1U << cfg->inertia_lift;
    const int32_t lifted = fx_clamp(change, -largest, largest) * (int32_t)lift;
    const int32_t nominal = fx_asr(fx_mul_32x16(lifted, cfg->inertia), cfg->inertia_shift);
    const int32_t ratio_q13 = fx_asr(loop->inertia_q17, RATIO_SHIFT);

    return fx_asr(fx_sat16(nominal) * ratio_q13, 13U);
}

int32_t speed_loop_accelerate(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                              torque_range_t range)
{
    const step_t limited = fx_clamp(reference, -cfg->speed_max, cfg->speed_max);
    const int32_t torque = inertia_torque(loop, cfg, limited - loop->reference);

    loop->reference = limited;
    return fx_clamp(torque, range.lower, range.upper);
}

/*
 * Returns the change of the speed, net·2^(16 + shift − lift)/inertia. quotient: net·2^15/inertia,
 * which is the change / 2^(1 + shift − lift).
 */
static step_t scaled_response(const speed_loop_cfg_t *cfg, int32_t quotient)
{
    /*@ split cfg->inertia_shift; */
    const int32_t doubled = (int32_t)cfg->inertia_shift + 1;
    const uint32_t up = (uint32_t)fx_min(doubled, RESPONSE_SHIFT_MAX);
    const int32_t largest = fx_asr(CHANGE_MAX, up);
    const uint32_t scale = (uint32_t)1U << up;
    const int32_t lowered = fx_asr(quotient, cfg->inertia_lift);

    return fx_clamp(lowered, -largest, largest) * (int32_t)scale;
}

step_t speed_loop_response(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, int32_t current)
{
    const int32_t net = fx_sat16(current - pi_output(&loop->pi));
    const int32_t ratio_q13 = fx_asr(loop->inertia_q17, RATIO_SHIFT);
    const int32_t inertia = fx_asr(cfg->inertia * ratio_q13, 13U);
    step_t change = 0;

    if (inertia > 0) {
        change = scaled_response(cfg, (net * Q15_TO_Q30) / inertia);
    }
    return change;
}

static uint32_t is_heavy(const speed_loop_t *loop)
{
    return (loop->inertia_q17 >= SPEED_LOOP_HEAVY_Q17) ? 1U : 0U;
}

static bool has_file_gains(const speed_loop_t *loop)
{
    return (is_heavy(loop) | loop->halvings) == 0U;
}

static const pi_cfg_t *file_gains(const speed_loop_t *loop, const speed_loop_cfg_t *cfg)
{
    const bool soft = fx_abs(loop->reference) < cfg->soft_speed;

    return soft ? &cfg->soft : &cfg->pi;
}

/*
 * K_p is as large as the ripple of the estimate allows, whatever J is. A heavy rotor gets half of
 * K_i, which keeps the damping: relative to the damping with the configured J it is √(1/ratio), and
 * for a heavy rotor √(2/ratio). That is 0.82…1.15 for ratios of 0.75…3. A lowered bandwidth has
 * K_p/2 and K_i/4.
 *
 * SHIFT_MAX limits the shift of K_i. With that shift the largest error adds less than one LSB to
 * the integral.
 */
static pi_cfg_t gains_in_force(const speed_loop_t *loop, const speed_loop_cfg_t *cfg)
{
    const pi_cfg_t *const from = file_gains(loop, cfg);
    const uint32_t ki_shift = from->ki_shift + is_heavy(loop) + (2U * loop->halvings);

    return (pi_cfg_t){
        .kp = from->kp,
        .ki = from->ki,
        .kp_shift = from->kp_shift + loop->halvings,
        .ki_shift = (uint32_t)fx_min((int32_t)ki_shift, SHIFT_MAX),
    };
}

/* Returns the speed error, Q15 of 2·Ω_b. */
static int32_t half_speed_error(const speed_loop_cfg_t *cfg, step_t reference, step_t measured)
{
    return fx_sat16(fx_asr(reference - measured, cfg->error_shift));
}

/*
 * Returns the output of the PI with the gains in force. There are two calls of pi_step(), because
 * one call with a pointer to either set of gains makes every speed step longer.
 */
static int32_t regulate(speed_loop_t *loop, const speed_loop_cfg_t *cfg, int32_t half_error_q15,
                        int32_t feed_forward, int32_t reach)
{
    int32_t current;

    if (has_file_gains(loop)) {
        current = pi_step(&loop->pi, file_gains(loop, cfg), half_error_q15, feed_forward, reach);
    } else {
        const pi_cfg_t gains = gains_in_force(loop, cfg);

        current = pi_step(&loop->pi, &gains, half_error_q15, feed_forward, reach);
    }
    return current;
}

/*
 * pi_step() clamps symmetrically, so the range is shifted by its middle. When the sum of its ends
 * is odd, the shifted range reaches one LSB too far down; the fx_max() below cuts that off.
 */
static int32_t regulate_within(speed_loop_t *loop, const speed_loop_cfg_t *cfg,
                               int32_t half_error_q15, int32_t feed_forward, torque_range_t range)
{
    const int32_t middle = fx_asr(range.lower + range.upper, 1U);
    const int32_t reach = range.upper - middle;
    const int32_t beyond_middle = regulate(loop, cfg, half_error_q15, feed_forward - middle, reach);

    return fx_max(fx_sat15(middle + beyond_middle), range.lower);
}

int32_t speed_loop_step(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                        step_t measured, torque_range_t range)
{
    const int32_t feed_forward = speed_loop_accelerate(loop, cfg, reference, range);

    return regulate_within(loop, cfg, half_speed_error(cfg, loop->reference, measured),
                           feed_forward, range);
}

/* Returns the current that the PI would give for this error, without limits. */
static int32_t answer_to(const speed_loop_t *loop, const speed_loop_cfg_t *cfg,
                         int32_t half_error_q15)
{
    const pi_cfg_t gains = gains_in_force(loop, cfg);

    return pi_sum(&gains, half_error_q15, loop->pi.integral_q26);
}

/*
 * Moves the integral towards `load` by 2^-shift of the difference. load: the current less the part
 * that accelerates the rotor.
 */
static void follow_load(speed_loop_t *loop, int32_t load, uint32_t shift)
{
    const int32_t missing_q26 = (load * Q15_TO_Q26) - loop->pi.integral_q26;

    loop->pi.integral_q26 = fx_sat27(loop->pi.integral_q26 + fx_asr(missing_q26, shift));
}

int32_t speed_loop_within(speed_loop_t *loop, const speed_loop_cfg_t *cfg,
                          const speed_window_t *window, step_t reference, step_t measured,
                          int32_t wanted, torque_range_t range, speed_end_t *end)
{
    const step_t upper = fx_min(window->upper, cfg->speed_max);
    const step_t lower = fx_max(window->lower, -cfg->speed_max);
    const int32_t to_upper = half_speed_error(cfg, upper, measured);
    const int32_t to_lower = half_speed_error(cfg, lower, measured);
    const int32_t asked = fx_clamp(wanted, range.lower, range.upper);
    const step_t limited = fx_clamp(reference, -cfg->speed_max, cfg->speed_max);
    const int32_t of_inertia = inertia_torque(loop, cfg, limited - loop->reference);
    int32_t current;

    loop->reference = limited;
    if (asked > answer_to(loop, cfg, to_upper)) {
        *end = SPEED_END_UPPER;
        current = regulate_within(loop, cfg, to_upper, 0,
                                  (torque_range_t){.lower = range.lower, .upper = asked});
    } else if (asked < answer_to(loop, cfg, to_lower)) {
        *end = SPEED_END_LOWER;
        current = regulate_within(loop, cfg, to_lower, 0,
                                  (torque_range_t){.lower = asked, .upper = range.upper});
    } else {
        *end = SPEED_END_NONE;
        current = fx_sat15(asked);
        follow_load(loop, current - of_inertia, window->load_shift);
    }
    return current;
}

/* Moves the growth of the integral to J, if J stays within its limits. */
static void move_to_inertia(speed_loop_t *loop, const speed_loop_cfg_t *cfg, bool speeds_down,
                            int32_t before_q26)
{
    const int32_t added_q26 = loop->pi.integral_q26 - before_q26;
    const int32_t size =
        fx_asr(fx_mul_32x16(added_q26, cfg->inertia_rate), cfg->inertia_rate_shift);
    const int32_t wanted = loop->inertia_q17 + (speeds_down ? -size : size);

    if ((size != 0) && (wanted >= (cfg->inertia_least_q13 * Q13_TO_Q17)) &&
        (wanted <= (cfg->inertia_most_q13 * Q13_TO_Q17))) {
        loop->inertia_q17 = wanted;
        loop->pi.integral_q26 = before_q26;
    }
}

void speed_loop_learn(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t change,
                      int32_t integral_before_q26)
{
    const bool ramps = fx_abs(change) >= fx_asr(cfg->ramp, 1U);

    if ((cfg->inertia_rate != 0) && ramps) {
        move_to_inertia(loop, cfg, change < 0, integral_before_q26);
    }
}

/* Returns `whole` rounded down to a multiple of `turn` (1…50). */
static uint32_t multiple_below(int32_t whole, int32_t turn)
{
    /*@ split turn; */
    const int32_t beyond = whole % turn;
    const int32_t within = (beyond < 0) ? (beyond + turn) : beyond;

    return fx_unsigned(whole) - (uint32_t)within;
}

/* Returns the XOR of both halves of a position, for the check word. */
static uint32_t word_of_position(int64_t position_q32)
{
    const uint64_t bits = fx_unsigned64(position_q32);
    const uint64_t both = bits ^ (bits >> 32U);

    return (uint32_t)(both & UINT32_MAX);
}

static uint32_t word_of_profile(const position_loop_t *loop)
{
    return word_of_position(loop->profile_q32) ^ fx_unsigned(loop->profile_speed);
}

bool position_loop_holds(const position_loop_t *loop)
{
    return (word_of_profile(loop) ^ word_of_position(loop->zero_q32)) == loop->check;
}

/* Only the change goes into the check word, so a bit that has flipped stays visible. */
void position_loop_set_zero(position_loop_t *loop, int64_t zero_q32)
{
    loop->check ^= word_of_position(loop->zero_q32) ^ word_of_position(zero_q32);
    loop->zero_q32 = zero_q32;
}

void position_loop_recount(position_loop_t *loop, const position_loop_cfg_t *cfg,
                           int64_t position_q32)
{
    const uint64_t half_turn = (uint64_t)cfg->pole_pairs << HALF_TURN_SHIFT;
    const uint64_t zero = fx_unsigned64(loop->zero_q32);
    const uint64_t ahead = (fx_unsigned64(position_q32) - zero) + half_turn;
    const int32_t whole = fx_signed((uint32_t)(ahead >> WHOLE_TURN_SHIFT));
    const uint64_t turned = multiple_below(whole, (int32_t)cfg->pole_pairs);

    position_loop_set_zero(loop, fx_signed64(zero + (turned << WHOLE_TURN_SHIFT)));
}

int64_t position_loop_target(const position_loop_t *loop, int32_t target_q16)
{
    const int64_t from_zero = (int64_t)target_q16 * Q32_TO_Q16;

    return fx_signed64(fx_unsigned64(loop->zero_q32) + fx_unsigned64(from_zero));
}

void position_loop_reset(position_loop_t *loop, int64_t position_q32, step_t speed)
{
    const uint32_t before = word_of_profile(loop);

    loop->profile_q32 = position_q32;
    loop->profile_speed = speed;
    loop->check ^= before ^ word_of_profile(loop);
}

/*
 * Returns the distance from one position to another, the shorter way. Positions wrap as the rotor
 * position does.
 */
static int64_t distance(int64_t from_q32, int64_t to_q32)
{
    const uint64_t way = fx_unsigned64(to_q32) - fx_unsigned64(from_q32);

    return fx_signed64(way);
}

/*
 * Returns the position after `ticks` at this speed. speed · ticks is computed by two 32-bit
 * products and is exact for up to 2^15 ticks. A 64-bit product is a library call on Cortex-M0+.
 */
static int64_t advanced(int64_t position_q32, step_t speed, uint32_t ticks)
{
    const int32_t count = (int32_t)ticks;
    const int32_t upper = fx_asr(speed, 16U) * count;
    const uint32_t fraction = fx_unsigned(speed) & 0xFFFFU;
    const int32_t lower = (int32_t)fraction * count;
    const int64_t way = ((int64_t)upper * Q32_TO_Q16) + lower;
    const uint64_t there = fx_unsigned64(position_q32) + fx_unsigned64(way);

    return fx_signed64(there);
}

/* Returns |distance| in distance units, saturated. */
static uint32_t distance_units(const position_loop_cfg_t *cfg, int64_t distance_q32)
{
    const uint64_t magnitude =
        (distance_q32 < 0) ? (0U - fx_unsigned64(distance_q32)) : (uint64_t)distance_q32;
    const uint64_t units = magnitude >> cfg->distance_shift;

    return (units > DISTANCE_MAX) ? DISTANCE_MAX : (uint32_t)units;
}

/* Returns the largest speed from which the profile can still stop within `units`. */
static step_t braking_speed(const position_loop_cfg_t *cfg, uint32_t units)
{
    const int32_t c_q15 = cfg->softness_q15;
    const uint32_t share_q30 = units * (uint32_t)cfg->braking_inverse;
    const uint32_t c_q30 = (uint32_t)c_q15 * (uint32_t)c_q15;
    const int32_t root_q15 = (int32_t)trig_sqrt(share_q30 + c_q30);

    return fx_mul_32x16(cfg->speed_max, fx_min(root_q15 - c_q15, FX_Q15_MAX)) * 2;
}

static void advance_profile(position_loop_t *loop, const position_loop_cfg_t *cfg,
                            int64_t target_q32, uint32_t ticks)
{
    const int64_t distance_q32 = distance(loop->profile_q32, target_q32);
    const uint32_t units = distance_units(cfg, distance_q32);
    const step_t speed = (units == 0U) ? 0 : braking_speed(cfg, units);
    const step_t wanted = (distance_q32 < 0) ? -speed : speed;
    const uint32_t before = word_of_profile(loop);

    loop->profile_speed = fx_towards(loop->profile_speed, wanted, cfg->ramp);
    loop->profile_q32 = advanced(loop->profile_q32, loop->profile_speed, ticks);
    if ((units == 0U) && (loop->profile_speed == 0)) {
        loop->profile_q32 = target_q32;
    }
    loop->check ^= before ^ word_of_profile(loop);
}

/* Returns the lag in Q16 electrical turns, saturated at ±½ turn. */
static int32_t lag_q16(int64_t lag_q32)
{
    int32_t lag;

    if (lag_q32 >= ((int64_t)FX_Q15_MAX * Q32_TO_Q16)) {
        lag = FX_Q15_MAX;
    } else if (lag_q32 <= ((int64_t)FX_Q15_MIN * Q32_TO_Q16)) {
        lag = FX_Q15_MIN;
    } else {
        lag = fx_asr((int32_t)lag_q32, 16U);
    }
    return lag;
}

step_t position_loop_step(position_loop_t *loop, const position_loop_cfg_t *cfg, int64_t target_q32,
                          int64_t measured_q32, uint32_t ticks)
{
    const int32_t lag = lag_q16(distance(measured_q32, loop->profile_q32));
    const int32_t correction = fx_asr(lag * cfg->gain, cfg->gain_shift);

    advance_profile(loop, cfg, target_q32, ticks);
    return loop->profile_speed + fx_clamp(correction, -cfg->speed_max, cfg->speed_max);
}
