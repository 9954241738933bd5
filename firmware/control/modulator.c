#include "modulator.h"

#define ONE_Q12 (4096)
#define ONE_Q27 (0x8000000)
#define HALF_Q15 (0x4000)
#define ONE_Q15 (32768)
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

dq_t modulator_ratio(const modulator_t *mod, const modulator_cfg_t *cfg, dq_t voltage)
{
    const int32_t bound = cfg->ratio_max_q15;

    return (dq_t){
        .d = fx_clamp(fx_asr(mod->inverse_bus_q12 * voltage.d, 12U), -bound, bound),
        .q = fx_clamp(fx_asr(mod->inverse_bus_q12 * voltage.q, 12U), -bound, bound),
    };
}

/* Duty centred at ½ to counts. */
static uint16_t counts(const modulator_cfg_t *cfg, int32_t ratio_q15)
{
    const int32_t duty_q15 = fx_clamp(ratio_q15 + HALF_Q15, 0, ONE_Q15);

    return (uint16_t)fx_asr((duty_q15 * cfg->timer_counts) + HALF_Q15, 15U);
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
    const int32_t common = fx_asr(highest + lowest, 1U);

    return (compare_t){
        .phase = {counts(cfg, a - common), counts(cfg, b - common), counts(cfg, c - common)},
    };
}
