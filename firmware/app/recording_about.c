/* SPDX-License-Identifier: MIT */
#include "recording_about.h"

#include <stddef.h>

#define EXCEPTION_SHIFT (8U)

recorder_about_t recording_about(const about_t *about, hal_reset_t reset)
{
    recorder_about_t facts = {
        .tick_ps = about->rotation.tick_ps,
        .current_full_scale_ua = about->current_full_scale_ua,
        .bus_full_scale_uv = about->bus_full_scale_uv,
        .pole_pairs = about->rotation.pole_pairs,
        .reset = (uint32_t)reset.reason | (reset.exception << EXCEPTION_SHIFT),
    };

    recorder_about_name(&facts, about->name);
    for (uint32_t k = 0U; (k < RECORDER_BUILD_WORDS) && (about->build != NULL); k++) {
        facts.build[k] = about->build[k];
    }
    return facts;
}
