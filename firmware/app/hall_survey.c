/* SPDX-License-Identifier: MIT */
#include "hall_survey.h"

#include "barrier.h"
#include "fx.h"
#include "inlining.h"

#define Q16_TO_Q32_SHIFT (16U)

/* The barriers keep the order: the sums are written only while no survey is under way. */
void hall_survey_begin(hall_survey_t *survey, uint32_t ticks)
{
    survey->left = 0U;
    barrier_compiler();
    *survey = (hall_survey_t){.ticks = ticks};
    barrier_compiler();
    survey->left = ticks + 1U;
}

static void hall_survey_add(hall_survey_t *survey, uint32_t levels, sincos_t at)
{
    for (uint32_t k = 0U; k < HALL_SURVEY_SIGNALS; k++) {
        if (((levels >> k) & 1U) != 0U) {
            hall_survey_signal_t *const signal = &survey->signals[k];

            signal->middle.d += at.cos;
            signal->middle.q += at.sin;
            signal->high++;
        }
    }
}

RARE void hall_survey_step(hall_survey_t *survey, uint32_t levels, int32_t turns_q16)
{
    const uint32_t turns = fx_unsigned(turns_q16);
    const sincos_t at = trig_sincos(turns << Q16_TO_Q32_SHIFT);

    if (survey->left > survey->ticks) {
        survey->start_q16 = turns_q16;
    }
    if (survey->left == 1U) {
        survey->turn_q16 = fx_signed(turns - fx_unsigned(survey->start_q16));
    } else {
        hall_survey_add(survey, levels, at);
    }
    survey->left--;
}
