/* SPDX-License-Identifier: MIT */
#include "inductance.h"

#include "fx.h"
#include "trig.h"

#define QUARTERS (4U)
/*
 * A voltage that is demanded in tick k acts from k + 1 on. So the effect of a voltage that is
 * demanded for n ticks is measured in tick n + 2.
 */
#define DELAY_TICKS (2U)
#define RESPONSE_MAX (0x1000000)
#define CHANGE_MAX (0x3FFFF)
#define ONE_Q13 (8192)
#define TWO_Q27 (0x10000000)

/* Returns the sign of the voltage in tick k of the pulse, 0 after the pulse. */
static int32_t pulse_sign(const inductance_cfg_t *cfg, uint32_t k)
{
    const bool back = (k >= cfg->pulse_ticks) && (k < (3U * cfg->pulse_ticks));
    int32_t sign = 0;

    if (k < (QUARTERS * cfg->pulse_ticks)) {
        sign = back ? -1 : 1;
    }
    return sign;
}

static int32_t step_sign(const inductance_cfg_t *cfg, uint32_t k)
{
    return (k < cfg->step_ticks) ? -1 : 0;
}

/* Returns the tick of the test in which the last sample of the pulse is taken. */
static uint32_t pulse_end(const inductance_cfg_t *cfg)
{
    return (QUARTERS * cfg->pulse_ticks) + DELAY_TICKS;
}

bool inductance_holds_voltage(const inductance_cfg_t *cfg, uint32_t tick)
{
    return tick <= (pulse_end(cfg) + cfg->step_ticks);
}

dq_t inductance_voltage(const inductance_cfg_t *cfg, uint32_t tick)
{
    const int32_t pulse = pulse_sign(cfg, tick - 1U) - pulse_sign(cfg, tick - 2U);
    const bool steps = tick == (pulse_end(cfg) + 1U);

    return (dq_t){.d = steps ? -cfg->step_voltage : 0, .q = pulse * cfg->pulse_voltage};
}

static int32_t plus(int32_t sum, int32_t change)
{
    return fx_clamp(sum, -RESPONSE_MAX, RESPONSE_MAX) + change;
}

/*
 * Adds a sample that was taken between two ticks of the test voltage. before, after: sign of the
 * voltage in the tick before and after the sample. The sample ends the change of the first tick and
 * begins the change of the second. It counts as one half of the mean current of each. along:
 * current in the direction of the voltage.
 */
static void note(inductance_response_t *response, dq_t current, int32_t along, int32_t before,
                 int32_t after)
{
    response->change.d = plus(response->change.d, (before - after) * current.d);
    response->change.q = plus(response->change.q, (before - after) * current.q);
    response->carried = plus(response->carried, (before + after) * along);
}

/*
 * k: tick of the pulse whose voltage acts from this sample on. Before the pulse, k wraps to a
 * number for which pulse_sign() gives 0.
 */
static void note_pulse(inductance_t *test, const inductance_cfg_t *cfg, uint32_t k, dq_t current)
{
    note(&test->pulse, current, current.q, pulse_sign(cfg, k - 1U), pulse_sign(cfg, k));
}

static void note_step(inductance_t *test, const inductance_cfg_t *cfg, uint32_t k, dq_t current)
{
    if (k == 0U) {
        test->start_d = current.d;
    }
    note(&test->step, current, current.d - test->start_d, step_sign(cfg, k - 1U),
         step_sign(cfg, k));
}

bool inductance_step(inductance_t *test, const inductance_cfg_t *cfg, uint32_t tick, dq_t current)
{
    const uint32_t middle = pulse_end(cfg);

    if (tick <= middle) {
        note_pulse(test, cfg, tick - DELAY_TICKS, current);
    } else {
        note_step(test, cfg, tick - middle - DELAY_TICKS, current);
    }
    return tick >= (middle + cfg->step_ticks + DELAY_TICKS);
}

/*
 * Returns the response that the configured L_d would give to the test voltage less the voltage that
 * the resistance takes.
 */
static int32_t expected(int32_t nominal, int32_t voltage, int32_t carried, int32_t ticks,
                        int32_t resistance_q13)
{
    const int32_t mean = fx_sat16(carried / (2 * ticks));
    const int32_t left = voltage - fx_asr(mean * resistance_q13, 13U);

    return (nominal * fx_clamp(left, 0, FX_Q15_MAX)) / voltage;
}

/*
 * Returns change / nominal, Q13, saturated to 16 bits: an element of B times the configured L_d. 0
 * if `nominal`, the expected response, is 0.
 */
static int32_t element_q13(int32_t change, int32_t nominal)
{
    const int32_t bounded = fx_clamp(change, -CHANGE_MAX, CHANGE_MAX);

    return (nominal > 0) ? fx_sat16((bounded * ONE_Q13) / nominal) : 0;
}

/* Returns √((B_dd − B_qq)² + 4·B_dq²) with the sign of B_dd − B_qq. */
static int32_t apart(int32_t difference, int32_t twice_cross)
{
    const int32_t d = fx_sat16(difference);
    const int32_t c = fx_sat16(twice_cross);
    const int32_t d_square = d * d;
    const int32_t c_square = c * c;
    const int32_t root = (int32_t)trig_sqrt((uint32_t)d_square + (uint32_t)c_square);

    return (d < 0) ? -root : root;
}

/* along, across: 2·(configured L_d)/L_d and 2·(configured L_d)/L_q, Q13. */
static inductance_result_t result_of(int32_t along, int32_t across)
{
    inductance_result_t result = {INDUCTANCE_UNKNOWN, INDUCTANCE_UNKNOWN};

    if (along > 0) {
        result.ratio_q14 = fx_min(TWO_Q27 / along, FX_Q15_MAX);
        if (across > 0) {
            result.saliency_q13 = fx_clamp((along * ONE_Q13) / across, 1, FX_Q15_MAX);
        }
    }
    return result;
}

inductance_result_t inductance_result(const inductance_t *test, const inductance_cfg_t *cfg,
                                      int32_t resistance_q13)
{
    const int32_t step = expected(cfg->step_response, cfg->step_voltage, test->step.carried,
                                  (int32_t)cfg->step_ticks, resistance_q13);
    const int32_t pulse = expected(cfg->pulse_response, cfg->pulse_voltage, test->pulse.carried,
                                   (int32_t)QUARTERS * (int32_t)cfg->pulse_ticks, resistance_q13);
    const int32_t dd = element_q13(test->step.change.d, step);
    const int32_t qq = element_q13(test->pulse.change.q, pulse);
    const int32_t root = apart(dd - qq, 2 * element_q13(test->pulse.change.d, pulse));

    return (qq > 0) ? result_of(dd + qq + root, dd + qq - root) : result_of(2 * dd, 0);
}
