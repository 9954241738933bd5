#include "modulator.h"

#define ONE_Q26 (1 << 26)
#define ONE_Q27 (1 << 27)
#define HALF_Q15 (0x4000)
#define ONE_Q15 (32768)
#define HALF_SQRT3_Q15 (28378)

void modulator_reset(modulator_t *mod)
{
    mod->inverse_bus_q27 = ONE_Q27;
}

void modulator_track_bus(modulator_t *mod, const modulator_cfg_t *cfg, int16_t bus)
{
    const int32_t inverse = mod->inverse_bus_q27;
    /* Cut at −½: a step that large goes to the lower bound anyway, and the product stays in range. */
    const int32_t error_q26 = fx_max(ONE_Q26 - fx_mul_32x16(inverse, bus), -ONE_Q26 / 2);
    const int32_t correction_q21 = fx_mul_32x16(error_q26, fx_asr(inverse, 16U));

    mod->inverse_bus_q27 = fx_clamp(inverse + (correction_q21 * 64), ONE_Q27, cfg->inverse_max_q27);
}

int16_t modulator_limit(const modulator_cfg_t *cfg, int16_t bus)
{
    return (int16_t)fx_asr((int32_t)bus * cfg->ratio_max_q15, 15U);
}

dq_t modulator_ratio(const modulator_t *mod, dq_t voltage)
{
    return (dq_t){
        .d = fx_sat16(fx_asr(fx_mul_32x16(mod->inverse_bus_q27, voltage.d), 11U)),
        .q = fx_sat16(fx_asr(fx_mul_32x16(mod->inverse_bus_q27, voltage.q), 11U)),
    };
}

/* Duty centred at ½ to counts. */
static uint16_t counts(const modulator_cfg_t *cfg, int32_t ratio_q15)
{
    const int32_t duty_q15 = fx_clamp(ratio_q15 + HALF_Q15, 0, ONE_Q15);

    return (uint16_t)fx_asr((duty_q15 * (int32_t)cfg->timer_counts) + HALF_Q15, 15U);
}

compare_t modulator_compare(const modulator_cfg_t *cfg, ab_t ratio)
{
    const int32_t half_alpha = fx_asr(ratio.alpha, 1U);
    const int32_t beta_part = fx_asr((int32_t)ratio.beta * HALF_SQRT3_Q15, 15U);
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
