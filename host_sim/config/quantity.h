/* SPDX-License-Identifier: MIT */
// What one of an integer of the firmware is: the quantities that the rows of cfg.def and the words
// of the drive's state name.
#pragma once

#include "bases.h"

#include <string>

namespace nf
{

enum class Quantity {
    // Of a run.
    time_s,
    speed_rpm,
    angle_rad,
    angle_deg,
    current_a,
    voltage_v,
    torque_nm,
    share,
    // Words of the firmware.
    number,
    flag,
    state,
    fault,
    adc_current,
    adc_bus,
    adc_plain,
    current_q15,
    current_q26,
    current_q30,
    slope_q15,
    bus_current,
    voltage_q15,
    voltage_q26,
    inverse_q12,
    speed_step,
    speed_q15,
    ramp_step,
    turns_q32,
    turns_q16,
    shaft_q16,
    angle_q32,
    ticks,
    slow_periods,
    watch_periods,
    period_q15,
    ratio_q13,
    ratio_q14,
    ratio_q17,
    ratio_q15,
    ratio_q24,
    ratio_q30,
    compare,
    inductance_q13,
    flux_q13,
    resistance_q13,
    resistance_q15,
    reactance_q14,
    network_q15,
    network_q27,
    network_decay,
    network_gain,
    gradient,
    corner,
    flux_rate,
    torque_q28,
    torque_ramp,
    // Mantissas, see cfg.def.
    gain,
    gain_q16,
    integral_gain,
    voltage_gain,
    voltage_integral,
    heat_rate
};

// SI = (raw − zero) · one.
struct Format {
    const char *unit;
    const char *text; // of what one is, with {} for `base`
    double base;
    double one;
    double zero = 0;
};

// `exponent`: of a mantissa.
Format format_of(Quantity quantity, const Bases &bases, const drive_cfg_t &cfg,
                 unsigned exponent = 0);

// "Q15 of I_b = 40 A"
std::string format_text(const Format &format);

} // namespace nf
