/* SPDX-License-Identifier: MIT */
#include "rc_pulse.h"

#include "fx.h"

static bool is_between(uint32_t value, uint32_t least, uint32_t most)
{
    return (value >= least) && (value <= most);
}

/* Whether a period is within 1/4 of the one before it, or the first one. */
static bool is_regular(const rc_pulse_t *rc, uint32_t period)
{
    const uint32_t quarter = rc->period / 4U;

    return (rc->period == 0U) || is_between(period, rc->period - quarter, rc->period + quarter);
}

void rc_pulse_take(rc_pulse_t *rc, const hal_pulse_t *pulse, const input_cfg_t *cfg,
                   input_signal_t *signal, uint32_t tick)
{
    const uint32_t period = pulse->start - rc->start;
    const bool wide = is_between(pulse->width, fx_unsigned(cfg->least), fx_unsigned(cfg->most));
    const bool timely = is_between(period, RC_PULSE_PERIOD_MIN, RC_PULSE_PERIOD_MAX);

    if (wide && timely && is_regular(rc, period)) {
        input_signal_good(signal, pulse->width, tick);
    } else {
        input_signal_bad(signal, INPUT_LOST_SHAPE, INPUT_SIGNAL_BAD);
    }
    rc->start = pulse->start;
    rc->period = timely ? period : 0U;
}
