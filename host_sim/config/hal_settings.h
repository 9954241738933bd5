/* SPDX-License-Identifier: MIT */
// [hal] of a board file: what a target's hardware binding has to know beyond [board]. Optional;
// asked for only when a header for a binding is made.
#pragma once

namespace nf
{

// Whose limits a binding has; with `other` they are the user's own affair.
enum class Chip {
    stm32g431,
    other
};

// The level of the over-current comparators that opens the gates.
enum class BreakPolarity {
    active_high,
    active_low
};

struct HalSettings {
    Chip chip = Chip::stm32g431;
    double adc_settling_ns = 0; // low side on before its shunt can be sampled
    double adc_sampling_ns = 0; // sample switch closed
    BreakPolarity break_polarity = BreakPolarity::active_high;
    double shunt_ohm = 0;
    double amplifier_gain = 0;   // shunt to converter; negative: current into the motor counts down
    double amplifier_zero_v = 0; // at the converter, without current
    int pga_gain =
        0; // the part of the gain behind the comparators' inputs; 1: all of it is before them
    double adc_reference_v = 0;
    double bus_divider = 0; // bus to converter
};

} // namespace nf
