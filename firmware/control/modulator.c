#include "modulator.h"

#define ONE_Q12 (4096)
#define ONE_Q27 (0x8000000)
#define HALF_Q15 (0x4000)
#define HALF_SQRT3_Q15 (28378)

void modulator_reset(modulator_t *mod)
{
    mod->inverse_bus_q12 = ONE_Q12;
}

void modulator_track_bus(modulator_t *mod, const modulator_cfg_t *cfg, int32_t bus)
{
    const int32_t inverse = mod->inverse_bus_q12;
    /* |error| < 8 in Q12, so that the product stays below 2^30. */
    const int32_t error_q12 = fx_asr(ONE_Q27 - (inverse * bus), 15U);
    const int32_t next = inverse + fx_asr((error_q12 * inverse) + (ONE_Q12 / 2), 12U);

    mod->inverse_bus_q12 = fx_clamp(next, ONE_Q12, cfg->inverse_max_q12);
}

int32_t modulator_limit(const modulator_cfg_t *cfg, int32_t bus)
{
    return fx_asr(bus * cfg->ratio_max_q15, 15U);
}

dq_t modulator_ratio(const modulator_t *mod, dq_t voltage)
{
    return (dq_t){
        .d = fx_sat16(fx_asr(mod->inverse_bus_q12 * voltage.d, 12U)),
        .q = fx_sat16(fx_asr(mod->inverse_bus_q12 * voltage.q, 12U)),
    };
}

/* Duty to counts, rounded. */
static uint16_t counts(int32_t duty_q15, int32_t timer_counts)
{
    return (uint16_t)fx_asr((fx_usat15(duty_q15) * timer_counts) + HALF_Q15, 15U);
}

compare_t modulator_compare(const modulator_cfg_t *cfg, ab_t ratio)
{
    const int32_t half_alpha = fx_asr(ratio.alpha, 1U);
    const int32_t beta_part = fx_asr(ratio.beta * HALF_SQRT3_Q15, 15U);
    const int32_t a = ratio.alpha;
    const int32_t b = beta_part - half_alpha;
    const int32_t c = -beta_part - half_alpha;
    const int32_t highest = fx_max(fx_max(a, b), c);
    const int32_t lowest = fx_min(fx_min(a, b), c);
    const int32_t centre = HALF_Q15 - fx_asr(highest + lowest, 1U);
    const int32_t timer = cfg->timer_counts;

    return (compare_t){
        .phase = {counts(a + centre, timer), counts(b + centre, timer), counts(c + centre, timer)},
    };
}
