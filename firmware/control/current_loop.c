/* SPDX-License-Identifier: MIT */
#include "current_loop.h"

#include <stdbool.h>

/*
 * Fractional bits of ω·L, one more than the gains have. A product with a 16-bit current still fits
 * into 32 bits.
 */
#define REACTANCE_BITS (14U)

void current_loop_turn(current_loop_t *loop, sincos_t angle)
{
    const ab_t integral = {pi_output(&loop->pi_d), pi_output(&loop->pi_q)};
    const dq_t turned = transforms_park(integral, angle);

    pi_reset(&loop->pi_d, fx_sat16(turned.d));
    pi_reset(&loop->pi_q, fx_sat16(turned.q));
}

/* Returns the voltage of one axis, limited to the part of the circle that the other axis leaves. */
static int32_t limit_to_rest(pi_t *pi, int32_t voltage, int32_t other, int32_t limit)
{
    const int32_t room = (limit * limit) - (other * other);
    int32_t limited = voltage;

    if ((voltage * voltage) > room) {
        const int32_t bound = (int32_t)trig_sqrt((uint32_t)fx_max(room, 0));

        limited = fx_clamp(voltage, -bound, bound);
        pi_unwind(pi, voltage - limited);
    }
    return limited;
}

void current_loop_plan(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       int32_t speed_q15)
{
    const int32_t emf = fx_asr(speed_q15 * cfg->emf_q13, CURRENT_LOOP_GAIN_BITS);

    loop->reactance_q14.d = fx_asr(speed_q15 * cfg->reactance_d_q13, REACTANCE_BITS);
    loop->reactance_q14.q = fx_asr(speed_q15 * cfg->reactance_q_q13, REACTANCE_BITS);
    loop->constant.d = fx_asr(reference.d * cfg->resistance_q13, CURRENT_LOOP_GAIN_BITS);
    loop->constant.q = fx_asr(reference.q * cfg->resistance_q13, CURRENT_LOOP_GAIN_BITS) + emf;
}

dq_t current_loop_model(const current_loop_t *loop, dq_t current)
{
    return (dq_t){
        .d = loop->constant.d - fx_asr(loop->reactance_q14.q * fx_sat16(current.q), REACTANCE_BITS),
        .q = loop->constant.q + fx_asr(loop->reactance_q14.d * fx_sat16(current.d), REACTANCE_BITS),
    };
}

void current_loop_take_over(current_loop_t *loop, dq_t voltage)
{
    pi_unwind(&loop->pi_d, fx_clamp(-voltage.d, -FX_Q15_MAX, FX_Q15_MAX));
    pi_unwind(&loop->pi_q, fx_clamp(-voltage.q, -FX_Q15_MAX, FX_Q15_MAX));
}

static bool lies_in_circle(dq_t v, int32_t limit)
{
    const int32_t square = limit * limit;

    return transforms_square(v) <= (uint32_t)square;
}

/*
 * Limits a demand that lies outside of the circle. Each axis alone may lie within the limit.
 *
 * v_d is mainly −ω·L_q·i_q: below zero while the motor drives, above zero while it brakes. The axis
 * that comes second loses voltage. While the motor drives, v_q comes second: i_q falls, and |v_d|
 * falls with it. While it brakes, this order would let the EMF drive more i_q. More i_q needs more
 * v_d, until v_d takes the whole circle and nothing limits i_q. So v_d comes second while the motor
 * brakes: i_d falls, and with it the v_q that the EMF needs. The sign of ω·i_q* decides, not the
 * sign of v_d, because a broken wire changes the sign of v_d.
 */
static dq_t limit_to_circle(current_loop_t *loop, dq_t integral_q26, dq_t u, int32_t limit,
                            bool brakes)
{
    dq_t v = {
        .d = pi_limit(&loop->pi_d, integral_q26.d, u.d, limit),
        .q = pi_limit(&loop->pi_q, integral_q26.q, u.q, limit),
    };

    if (brakes) {
        v.d = limit_to_rest(&loop->pi_d, v.d, v.q, limit);
    } else {
        v.q = limit_to_rest(&loop->pi_q, v.q, v.d, limit);
    }
    return v;
}

dq_t current_loop_step(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       dq_t measured, int32_t limit)
{
    const dq_t model = current_loop_model(loop, measured);
    const dq_t error = {reference.d - measured.d, reference.q - measured.q};
    const dq_t integral_q26 = {pi_integral(&loop->pi_d, &cfg->pi_d, error.d),
                               pi_integral(&loop->pi_q, &cfg->pi_q, error.q)};
    const dq_t u = {pi_sum(&cfg->pi_d, error.d, integral_q26.d) + model.d,
                    pi_sum(&cfg->pi_q, error.q, integral_q26.q) + model.q};
    dq_t v = {fx_sat16(u.d), fx_sat16(u.q)};

    if (lies_in_circle(v, limit)) {
        loop->pi_d.integral_q26 = integral_q26.d;
        loop->pi_q.integral_q26 = integral_q26.q;
    } else {
        v = limit_to_circle(loop, integral_q26, u, limit,
                            (loop->reactance_q14.q * reference.q) < 0);
    }
    return v;
}
