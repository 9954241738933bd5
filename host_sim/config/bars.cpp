// SPDX-License-Identifier: MIT
#include "bars.h"

#include "si.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace nf
{
namespace
{

using M = MotorSettings;
using E = MeasuredSettings;

constexpr double SIGMAS = 2; // 95 % of a normal distribution

// A value with its bars in % of it.
struct Relative {
    const char *key;
    double M::*value;
    double E::*std_pct;
    double E::*bound_pct;
};
const Relative RELATIVE[] = {
    {"motor.resistance_ohm", &M::resistance_ohm, &E::resistance_std_pct, &E::resistance_bound_pct},
    {"motor.inductance_d_h", &M::inductance_d_h, &E::inductance_d_std_pct,
     &E::inductance_d_bound_pct},
    {"motor.inductance_q_h", &M::inductance_q_h, &E::inductance_q_std_pct,
     &E::inductance_q_bound_pct},
    {"motor.flux_linkage_wb", &M::flux_linkage_wb, &E::flux_linkage_std_pct,
     &E::flux_linkage_bound_pct},
    {"motor.rated_torque_nm", &M::rated_torque_nm, &E::flux_linkage_std_pct,
     &E::flux_linkage_bound_pct},
    {"motor.inertia_kg_m2", &M::inertia_kg_m2, &E::inertia_std_pct, &E::inertia_bound_pct},
};

// A bar in the value's own unit.
struct Absolute {
    const char *key;
    double E::*bar;
};
const Absolute ABSOLUTE[] = {
    {"motor.viscous_friction_nm_s", &E::viscous_friction_bar_nm_s},
    {"measured.coulomb_friction_nm", &E::coulomb_friction_bar_nm},
    {"measured.dead_time_s", &E::dead_time_bar_s},
    {"measured.knee_a", &E::knee_bar_a},
    {"measured.gain_mismatch_pct", &E::gain_mismatch_bar_pct},
    {"sensor.hall_edges_deg", &E::hall_edges_bar_deg},
};

constexpr int DIGITS_MAX = 17; // of a double

// Below this power of ten a number is written with an exponent.
constexpr int LEAST_PLAIN_PLACE = -4;

// In the form "2.13e-02", and the power of ten in it.
struct Scientific {
    std::string text;
    int place;

    Scientific(double number, int digits)
        : text(fmt::format("{:.{}e}", number, digits - 1)),
          place(std::stoi(text.substr(text.find('e') + 1)))
    {
    }
};

std::string significant(double number, int digits)
{
    const Scientific rounded(number, digits);
    if (rounded.place < LEAST_PLAIN_PLACE) {
        return rounded.text;
    }
    return fmt::format("{:.{}f}", std::stod(rounded.text), std::max(0, digits - 1 - rounded.place));
}

} // namespace

double error_bar(double std, double bound)
{
    return std::hypot(SIGMAS * std, bound);
}

double bar_of(const MotorSettings &motor, const MeasuredSettings &measured, const std::string &key)
{
    for (const Relative &row : RELATIVE) {
        if (row.key == key) {
            return std::abs(motor.*row.value) * PER_CENT *
                   error_bar(measured.*row.std_pct, measured.*row.bound_pct);
        }
    }
    const auto *row = std::find_if(std::begin(ABSOLUTE), std::end(ABSOLUTE),
                                   [&](const Absolute &any) { return any.key == key; });
    return row == std::end(ABSOLUTE) ? 0 : measured.*row->bar;
}

std::string two_digits(double number)
{
    return significant(number, 2);
}

std::string within_bar(double value, double bar)
{
    if (bar <= 0 || std::abs(value) <= 0) {
        return fmt::format("{}", value);
    }
    const int last_place = Scientific(bar, 2).place - 1;
    const int first_place = Scientific(value, DIGITS_MAX).place;
    return significant(value, std::clamp(first_place - last_place + 1, 1, DIGITS_MAX));
}

} // namespace nf
