/* SPDX-License-Identifier: MIT */
#include "input_signal.h"

#include "fx.h"

void input_signal_init(input_signal_t *signal, uint32_t tick)
{
    *signal = (input_signal_t){
        .why = (uint8_t)INPUT_LOST_SILENT, .lost = (uint8_t)INPUT_LOST_SILENT, .heard = tick};
}

void input_signal_good(input_signal_t *signal, uint32_t value, uint32_t tick)
{
    signal->values[0] = signal->values[1];
    signal->values[1] = signal->values[2];
    signal->values[2] = (uint16_t)value;
    signal->bad = 0U;
    signal->why = (uint8_t)INPUT_LOST_SILENT;
    signal->heard = tick;
    signal->count++;
    if (signal->good < INPUT_SIGNAL_GOOD) {
        signal->good++;
    }
    if (signal->good == INPUT_SIGNAL_GOOD) {
        signal->lost = (uint8_t)INPUT_LOST_NOT;
    }
}

/* The signal is lost, for what was wrong with its last bad reading. */
static void lose_signal(input_signal_t *signal)
{
    signal->good = 0U;
    signal->lost = signal->why;
}

void input_signal_bad(input_signal_t *signal, input_lost_t why, uint32_t most)
{
    signal->why = (uint8_t)why;
    signal->noisy = true;
    if (signal->bad < UINT8_MAX) {
        signal->bad++;
    }
    if ((signal->lost != (uint8_t)INPUT_LOST_NOT) || (signal->bad >= most)) {
        lose_signal(signal);
    }
}

void input_signal_step(input_signal_t *signal, uint32_t tick, uint32_t timeout_ticks)
{
    if ((tick - signal->heard) > timeout_ticks) {
        lose_signal(signal);
        signal->heard = tick - timeout_ticks - 1U; /* so the difference does not wrap */
    }
}

bool input_signal_was_noisy(input_signal_t *signal)
{
    const bool noisy = signal->noisy;

    signal->noisy = false;
    return noisy;
}

uint32_t input_signal_value(const input_signal_t *signal)
{
    const int32_t a = (int32_t)signal->values[0];
    const int32_t b = (int32_t)signal->values[1];
    const int32_t c = (int32_t)signal->values[2];

    return fx_unsigned(fx_max(fx_min(a, b), fx_min(fx_max(a, b), c)));
}

const char *input_signal_text(uint32_t lost)
{
    static const char *const texts[INPUT_LOSSES] = {
        "it is there",
        "no signal",
        "the board has no pin for it",
        "its voltage is below its range",
        "its voltage is above its range",
        "its pulses have wrong widths or periods",
        "its checksums are wrong",
        "it is inverted, as bidirectional DShot, which is not supported",
    };

    return texts[(lost < (uint32_t)INPUT_LOSSES) ? lost : (uint32_t)INPUT_LOST_SILENT];
}
