// SPDX-License-Identifier: MIT
#include "quantity.h"

#include "si.h"

#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

// What a base may depend on.
struct Context {
    const Bases &bases;
    const drive_cfg_t &cfg;
    unsigned exponent;

    double slow_period() const
    {
        return bases.control_period_s * static_cast<double>(cfg.slow_ticks);
    }

    double watch_period() const
    {
        return slow_period() * SUPERVISION_STEPS;
    }

    // I_x
    double network_current() const
    {
        return std::ldexp(bases.current_a, static_cast<int>(cfg.observer.current_shift));
    }

    // One of the observer's weights.
    double weight() const
    {
        return std::ldexp(1.0, -12 - static_cast<int>(cfg.observer.weight_shift));
    }

    double mantissa(int bits) const
    {
        return std::ldexp(1.0, -bits - static_cast<int>(exponent));
    }

    // Of the voltage drive's PI: U_b by 2·Ω_b.
    double volt_seconds() const
    {
        return bases.voltage_v / (2 * bases.speed_el_rad_s);
    }
};

double one(const Context & /*c*/)
{
    return 1;
}

struct Row {
    Quantity quantity;
    int bits; // one is 2^-bits of the base
    const char *unit;
    const char *text;
    double (*base)(const Context &);
};

using Q = Quantity;

constexpr Row ROWS[] = {
    {Q::time_s, 0, "s", "", one},
    {Q::speed_rpm, 0, "rpm", "", one},
    {Q::angle_rad, 0, "rad", "", one},
    {Q::angle_deg, 0, "deg", "", one},
    {Q::current_a, 0, "A", "", one},
    {Q::voltage_v, 0, "V", "", one},
    {Q::torque_nm, 0, "N m", "", one},
    {Q::share, 0, "", "", one},
    {Q::number, 0, "", "integer", one},
    {Q::flag, 0, "", "flag", one},
    {Q::state, 0, "", "state", one},
    {Q::fault, 0, "", "fault", one},
    {Q::adc_current, 0, "A", "ADC count, one = {:.6g} A",
     [](const Context &c) {
         return std::ldexp(c.bases.current_a, static_cast<int>(c.cfg.sampling.current_shift) - 15);
     }},
    {Q::adc_bus, 0, "V", "ADC count, one = {:.6g} V",
     [](const Context &c) {
         return std::ldexp(c.bases.voltage_v, static_cast<int>(c.cfg.sampling.bus_shift) - 15);
     }},
    {Q::adc_plain, 0, "", "ADC count", one},
    {Q::current_q15, 15, "A", "Q15 of I_b = {:.6g} A",
     [](const Context &c) { return c.bases.current_a; }},
    {Q::current_q26, 26, "A", "Q26 of I_b = {:.6g} A",
     [](const Context &c) { return c.bases.current_a; }},
    {Q::current_q30, 30, "A", "Q30 of I_b = {:.6g} A",
     [](const Context &c) { return c.bases.current_a; }},
    {Q::slope_q15, 15, "A/s", "Q15 of I_b a tick = {:.6g} A/s",
     [](const Context &c) { return c.bases.current_a / c.bases.control_period_s; }},
    {Q::bus_current, 15, "A", "Q15 of 1.5 I_b = {:.6g} A",
     [](const Context &c) { return BUS_CURRENT_FACTOR * c.bases.current_a; }},
    {Q::voltage_q15, 15, "V", "Q15 of U_b = {:.6g} V",
     [](const Context &c) { return c.bases.voltage_v; }},
    {Q::voltage_q26, 26, "V", "Q26 of U_b = {:.6g} V",
     [](const Context &c) { return c.bases.voltage_v; }},
    {Q::inverse_q12, 12, "1/V", "Q12 of 1/U_b = {:.6g} 1/V",
     [](const Context &c) { return 1 / c.bases.voltage_v; }},
    {Q::speed_step, 0, "rpm", "2^-32 turn el a tick = {:.6g} rpm",
     [](const Context &c) { return c.bases.rpm_from_step(1); }},
    {Q::speed_q15, 15, "rpm", "Q15 of W_b = {:.6g} rpm",
     [](const Context &c) {
         return c.bases.rpm_from_step(std::ldexp(1.0, 15 + c.bases.speed_shift));
     }},
    {Q::ramp_step, 0, "rpm/s", "2^-32 turn el a tick, each slow period = {:.6g} rpm/s",
     [](const Context &c) { return c.bases.rpm_from_step(1) / c.slow_period(); }},
    {Q::turns_q32, 32, "turns el", "Q32", one},
    {Q::turns_q16, 16, "turns el", "Q16", one},
    {Q::shaft_q16, 16, "turns", "Q16 of a turn of the shaft", one},
    {Q::angle_q32, 32, "deg", "Q32 of {:.6g} deg el", [](const Context & /*c*/) { return 360.0; }},
    {Q::ticks, 0, "s", "ticks of {:.6g} s",
     [](const Context &c) { return c.bases.control_period_s; }},
    {Q::slow_periods, 0, "s", "slow periods of {:.6g} s",
     [](const Context &c) { return c.slow_period(); }},
    {Q::watch_periods, 0, "s", "supervision's periods of {:.6g} s",
     [](const Context &c) { return c.watch_period(); }},
    {Q::period_q15, 15, "s", "Q15 of a tick = {:.6g} s",
     [](const Context &c) { return c.bases.control_period_s; }},
    {Q::ratio_q13, 13, "", "Q13", one},
    {Q::ratio_q14, 14, "", "Q14", one},
    {Q::ratio_q17, 17, "", "Q17", one},
    {Q::ratio_q15, 15, "", "Q15", one},
    {Q::ratio_q24, 24, "", "Q24", one},
    {Q::ratio_q30, 30, "", "Q30", one},
    {Q::compare, 0, "", "", [](const Context &c) { return 1.0 / c.cfg.modulator.timer_counts; }},
    {Q::inductance_q13, 13, "H", "Q13 of U_b/(I_b W_b) = {:.6g} H",
     [](const Context &c) {
         return c.bases.voltage_v / c.bases.current_a / c.bases.speed_el_rad_s;
     }},
    {Q::flux_q13, 13, "Wb", "Q13 of U_b/W_b = {:.6g} Wb",
     [](const Context &c) { return c.bases.voltage_v / c.bases.speed_el_rad_s; }},
    {Q::resistance_q13, 13, "Ohm", "Q13 of U_b/I_b = {:.6g} Ohm",
     [](const Context &c) { return c.bases.voltage_v / c.bases.current_a; }},
    {Q::resistance_q15, 15, "Ohm", "Q15 of U_b/I_b = {:.6g} Ohm",
     [](const Context &c) { return c.bases.voltage_v / c.bases.current_a; }},
    {Q::reactance_q14, 14, "Ohm", "Q14 of U_b/I_b = {:.6g} Ohm",
     [](const Context &c) { return c.bases.voltage_v / c.bases.current_a; }},
    {Q::network_q15, 15, "A", "Q15 of I_x = {:.6g} A",
     [](const Context &c) { return c.network_current(); }},
    {Q::network_q27, 27, "A", "Q27 of I_x = {:.6g} A",
     [](const Context &c) { return c.network_current(); }},
    {Q::network_decay, 0, "", "one = {:.6g}",
     [](const Context &c) { return c.weight() * c.network_current() / c.bases.current_a; }},
    {Q::network_gain, 0, "A/V", "one = {:.6g} A/V",
     [](const Context &c) { return c.weight() * c.network_current() / c.bases.voltage_v; }},
    {Q::gradient, 0, "A2", "",
     [](const Context &c) { return c.bases.current_a * c.network_current(); }},
    {Q::corner, 32, "rad/s", "Q32 of a turn a tick = {:.6g} rad/s",
     [](const Context &c) { return 2 * PI / c.bases.control_period_s; }},
    {Q::flux_rate, 15, "1/(A s)", "Q15 of 1/I_b a slow period = {:.6g} 1/(A s)",
     [](const Context &c) { return 1 / c.bases.current_a / c.slow_period(); }},
    {Q::torque_q28, 28, "N m", "Q28 of T_b = {:.6g} N m",
     [](const Context &c) { return c.bases.torque_nm(); }},
    {Q::torque_ramp, 28, "N m/s", "Q28 of T_b, each slow period = {:.6g} N m/s",
     [](const Context &c) { return c.bases.torque_nm() / c.slow_period(); }},
    {Q::gain, 0, "", "one = {:.6g}", [](const Context &c) { return c.mantissa(0); }},
    {Q::gain_q16, 0, "", "one = {:.6g}", [](const Context &c) { return c.mantissa(16); }},
    {Q::integral_gain, 0, "", "one = {:.6g}",
     [](const Context &c) { return c.mantissa(PI_INTEGRAL_BITS); }},
    {Q::voltage_gain, 0, "V s/rad", "one = {:.6g} V s/rad",
     [](const Context &c) { return c.mantissa(0) * c.volt_seconds(); }},
    {Q::voltage_integral, 0, "V/rad", "one = {:.6g} V/rad",
     [](const Context &c) {
         return c.mantissa(PI_INTEGRAL_BITS) * c.volt_seconds() / c.slow_period();
     }},
    {Q::heat_rate, 0, "1/s", "one = {:.6g} 1/s",
     [](const Context &c) { return c.mantissa(16) / c.watch_period(); }},
};

constexpr std::size_t COUNT = sizeof ROWS / sizeof ROWS[0];

constexpr bool in_order()
{
    for (std::size_t k = 0; k < COUNT; k++) {
        if (static_cast<std::size_t>(ROWS[k].quantity) != k) {
            return false;
        }
    }
    return COUNT == static_cast<std::size_t>(Quantity::heat_rate) + 1;
}
static_assert(in_order(), "a row for each quantity, at its place");

} // namespace

Format format_of(Quantity quantity, const Bases &bases, const drive_cfg_t &cfg, unsigned exponent)
{
    const Row &row = ROWS[static_cast<std::size_t>(quantity)];
    const double base = row.base({bases, cfg, exponent});
    Format format = {row.unit, row.text, base, std::ldexp(base, -row.bits)};
    if (quantity == Quantity::adc_current) {
        format.zero = std::ldexp(1.0, 14 - static_cast<int>(cfg.sampling.current_shift));
    } else if (quantity == Quantity::compare) {
        format.text = "count of {:.6g}";
        format.base = 1 / base;
    } else if (quantity == Quantity::gradient) {
        const int bits = 30 - static_cast<int>(cfg.observer.gradient_shift);
        format.text = bits == 18 ? "Q18 of I_b I_x = {:.6g} A2"
                                 : "Q(30 - gradient_shift) of I_b I_x = {:.6g} A2";
        format.one = std::ldexp(base, -bits);
    }
    return format;
}

std::string format_text(const Format &format)
{
    return fmt::format(fmt::runtime(format.text), format.base);
}

} // namespace nf
