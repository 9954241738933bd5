// SPDX-License-Identifier: MIT
#include "input_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double PULSE_HZ = 1e7;         // unit of a pulse's width, HAL_PULSE_HZ
constexpr double FULL_Q15 = 32767;       // of the converter, and the largest reading
constexpr int32_t DSHOT_READINGS = 2000; // throttle 48 to 2047
constexpr double SPAN_MIN = 0.01;        // of full scale: a shorter way is no throttle
constexpr double PERCENT = 100;
constexpr double TIMEOUT_S = 0.1; // where nobody has chosen it
constexpr double TIMEOUT_MIN_S = 0.05;
// A voltage is read every 128 ticks, and after 256 where the temperature is measured between
// (hal/stm32g4/hal_g4.c). One reading may be missing or bad: 384. The background may be late: 16.
constexpr double VOLTAGE_TICKS = 400;

int32_t rounded(double value)
{
    return static_cast<int32_t>(std::lround(value));
}

void set_voltage(input_cfg_t &c, const InputSettings &input)
{
    const double low = input.voltage_low_pct;
    const double high = input.voltage_high_pct;
    require({"input.voltage_low_pct", low}, input.voltage_margin_pct, PERCENT * (1 - SPAN_MIN),
            "input.voltage_margin_pct");
    require({"input.voltage_high_pct", high}, low + PERCENT * SPAN_MIN,
            PERCENT - input.voltage_margin_pct, "input.voltage_low_pct and voltage_margin_pct");
    const double scale = FULL_Q15 / PERCENT;
    c.least = rounded(input.voltage_margin_pct * scale);
    c.low = rounded(low * scale);
    c.high = rounded(high * scale);
    c.most = rounded((PERCENT - input.voltage_margin_pct) * scale);
}

void set_pulse(input_cfg_t &c, const InputSettings &input)
{
    require({"input.pulse_high_s", input.pulse_high_s},
            input.pulse_low_s + SPAN_MIN * FULL_Q15 / PULSE_HZ, FULL_Q15 / PULSE_HZ,
            "input.pulse_low_s");
    c.least = rounded((input.pulse_low_s - input.pulse_margin_s) * PULSE_HZ);
    c.low = rounded(input.pulse_low_s * PULSE_HZ);
    c.high = rounded(input.pulse_high_s * PULSE_HZ);
    c.most = rounded((input.pulse_high_s + input.pulse_margin_s) * PULSE_HZ);
}

void set_range(input_cfg_t &c, const InputSettings &input)
{
    switch (input.kind) {
    case InputKind::voltage:
        set_voltage(c, input);
        break;
    case InputKind::rc_pulse:
        set_pulse(c, input);
        break;
    case InputKind::dshot:
        c.high = DSHOT_READINGS;
        c.most = DSHOT_READINGS;
        break;
    case InputKind::none:
        break;
    }
    c.middle = input.both_ways ? (c.low + c.high) / 2 : c.low;
}

void set_throttle(input_cfg_t &c, const InputSettings &input, const Bases &b)
{
    keep(c.dead_q15, input.dead_band_pct / PERCENT * Q15, 0, Q15 / 2);
    keep(c.expo_q15, input.expo_pct / PERCENT * Q15, 0, FULL_Q15);
    keep(c.share_q15, input.largest_pct / PERCENT * FULL_Q15, 1, FULL_Q15);
    if (input.reversed) {
        c.share_q15 = -c.share_q15;
    }
    keep(c.slope_q30, input.slope_pct_s / PERCENT * b.control_period_s * Q30, 1, Q30 - 1);
}

// The default is the same for each kind: a longer time is locked on a running board, another kind
// is not.
double timeout_s(const InputSettings &input, const Bases &b)
{
    const double voltage_s = VOLTAGE_TICKS * b.control_period_s;
    if (input.timeout_s <= 0) {
        return std::max(TIMEOUT_S, voltage_s);
    }
    const bool by_pwm = input.kind == InputKind::voltage && voltage_s > TIMEOUT_MIN_S;
    require({"input.timeout_s", input.timeout_s}, by_pwm ? voltage_s : TIMEOUT_MIN_S, HUGE_VAL,
            by_pwm
                ? "a voltage is read every 128 to 256 periods of board.pwm_frequency_hz, and 400 "
                  "bear a missing reading"
                : "a short gap of a sound input is no loss");
    return input.timeout_s;
}

} // namespace

input_cfg_t make_input(const InputSettings &input, const Bases &b)
{
    input_cfg_t c{};
    c.kind = static_cast<uint32_t>(input.kind);
    c.commands = static_cast<uint32_t>(input.commands);
    c.button = static_cast<uint32_t>(input.button);
    set_range(c, input);
    set_throttle(c, input, b);
    const double share =
        input.voltage_filter_s > 0 ? -std::expm1(-b.control_period_s / input.voltage_filter_s) : 1;
    keep(c.filter_q15, share * Q15, 1, FULL_Q15);
    // Rounded up: neither is 0.
    c.timeout_ticks = static_cast<uint32_t>(std::ceil(timeout_s(input, b) / b.control_period_s));
    c.arm_ticks = static_cast<uint32_t>(std::ceil(input.arm_s / b.control_period_s));
    return c;
}

} // namespace nf
