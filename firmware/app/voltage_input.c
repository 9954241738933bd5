/* SPDX-License-Identifier: MIT */
#include "voltage_input.h"

#include "fx.h"

#define Q15_TO_Q30 (15U)
#define RATE_MAX (32767U)
#define Q15_ONE (32768)

/* Returns the share of the change that the low-pass takes over in `ticks` ticks, Q15. */
static int32_t filter_rate(uint32_t filter_q15, uint32_t ticks)
{
    const uint64_t rate = (uint64_t)filter_q15 * ticks;

    return (int32_t)((rate < RATE_MAX) ? rate : RATE_MAX);
}

/* The first good count sets the low-pass. */
static void smooth(voltage_input_t *voltage, int32_t reading_q15, int32_t rate_q15, bool first)
{
    const uint32_t to_q30 = fx_unsigned(reading_q15) << Q15_TO_Q30;
    const int32_t to = fx_signed(to_q30);

    if (first) {
        voltage->smooth_q30 = to;
    } else {
        const int64_t change = (int64_t)to - voltage->smooth_q30;

        voltage->smooth_q30 += (int32_t)((change * rate_q15) / Q15_ONE);
    }
}

static void take_conversion(voltage_input_t *voltage, uint32_t count, uint32_t shift,
                            const input_cfg_t *cfg, input_signal_t *signal, uint32_t tick)
{
    const uint32_t scaled = (count & (0x7FFFU >> shift)) << shift;
    const int32_t reading_q15 = fx_signed(scaled);

    if (reading_q15 < cfg->least) {
        input_signal_bad(signal, INPUT_LOST_LOW, INPUT_SIGNAL_ANY);
    } else if (reading_q15 > cfg->most) {
        input_signal_bad(signal, INPUT_LOST_HIGH, INPUT_SIGNAL_ANY);
    } else {
        smooth(voltage, reading_q15,
               filter_rate(fx_unsigned(cfg->filter_q15), tick - voltage->tick), signal->good == 0U);
        input_signal_good(signal, fx_unsigned(voltage->smooth_q30) >> Q15_TO_Q30, tick);
    }
    voltage->tick = tick;
}

void voltage_input_take(voltage_input_t *voltage, const hal_inputs_t *inputs, uint32_t shift,
                        const input_cfg_t *cfg, input_signal_t *signal, uint32_t tick)
{
    const bool ended = inputs->conversions != voltage->conversions;

    voltage->conversions = inputs->conversions;
    if (inputs->throttle == HAL_NO_THROTTLE) {
        input_signal_bad(signal, INPUT_LOST_NO_PIN, INPUT_SIGNAL_ANY);
    } else if (ended) {
        take_conversion(voltage, inputs->throttle, shift, cfg, signal, tick);
    } else {
        /* the same conversion is no reading again */
    }
}
