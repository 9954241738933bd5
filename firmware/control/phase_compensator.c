/* SPDX-License-Identifier: MIT */
#include "phase_compensator.h"

#include "trig.h"

void phase_compensator_start(phase_compensator_t *comp, angle_t angle)
{
    comp->angle = angle;
    comp->current_angle = 0;
}

/* Returns α_r of (40), not yet negated for backward rotation. */
static int32_t current_angle(const phase_compensator_cfg_t *cfg, dq_t current)
{
    const int32_t d = fx_sat16(current.d);
    const int32_t q = fx_min(fx_max(fx_abs(current.q), cfg->current_min), FX_Q15_MAX);

    return fx_signed(trig_atan2((int16_t)d, (int16_t)q));
}

int32_t phase_compensator_step(phase_compensator_t *comp, const phase_compensator_cfg_t *cfg,
                               dq_t current, angle_t rotor, step_t speed, bool forwards)
{
    const int32_t highest = forwards ? cfg->lead_max : cfg->brake_max;
    const int32_t lowest = forwards ? -cfg->brake_max : -cfg->lead_max;
    const angle_t ahead = comp->angle - rotor;
    const int32_t lead = fx_clamp(fx_signed(ahead), lowest, highest);
    const int32_t turn = fx_asr(fx_mul_32x16(comp->current_angle, cfg->gain), cfg->gain_shift);

    comp->angle =
        rotor + fx_unsigned(lead) + fx_unsigned(speed) + fx_unsigned(forwards ? turn : -turn);
    comp->current_angle = current_angle(cfg, current);
    return lead;
}
