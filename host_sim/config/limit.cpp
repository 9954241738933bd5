// SPDX-License-Identifier: MIT
#include "limit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{

double rounded(const SettingLimit &limit, int digits)
{
    if (!(std::abs(limit.value) > 0)) {
        return 0;
    }
    // Only whole powers of ten are exact: a digit behind the point is made by a division.
    const double places = digits - 1 - std::floor(std::log10(std::abs(limit.value)));
    const double power = std::pow(10.0, std::abs(places));
    const double count = places > 0 ? limit.value * power : limit.value / power;
    const auto value_of = [&](double whole) { return places > 0 ? whole / power : whole * power; };
    const double near = value_of(std::round(count));
    const bool is_allowed = limit.at_most ? near <= limit.value : near >= limit.value;
    return is_allowed ? near : value_of(limit.at_most ? std::floor(count) : std::ceil(count));
}

std::string limit_number(const SettingLimit &limit, int digits)
{
    constexpr int WHOLE = 10; // a larger number is written with a power of ten
    return fmt::format("{:.{}g}", rounded(limit, digits), std::max(digits, WHOLE));
}

std::string limits_text(double lowest, double highest, int digits)
{
    return fmt::format("{} to {}", limit_number({false, lowest}, digits),
                       limit_number({true, highest}, digits));
}

} // namespace nf
