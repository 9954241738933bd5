// SPDX-License-Identifier: MIT
#include "numbers.h"

#include "setting_error.h"

namespace nf
{

void require(double number, double lo, double hi, const Source &setting, const char *what)
{
    if (number >= lo && number <= hi) {
        return;
    }
    const double bound = number > hi ? hi : lo;
    const bool at_most = (number > hi) == (setting.power > 0);
    throw SettingError(setting.key, setting.value,
                       {at_most, setting.value * std::pow(bound / number, 1 / setting.power)},
                       what);
}

void require(const Source &setting, double lo, double hi, const char *what)
{
    require(setting.value, lo, hi, setting, what);
}

Mantissa normalise(double number, int shift_min, int shift_max, const Source &setting,
                   const char *what)
{
    require(number, 0, std::ldexp(MANTISSA_MAX, -shift_min), setting, what);
    int shift = shift_max;
    while (shift > shift_min && std::round(std::ldexp(number, shift)) > MANTISSA_MAX) {
        shift--;
    }
    return {static_cast<int32_t>(std::lround(std::ldexp(number, shift))),
            static_cast<uint32_t>(shift)};
}

pi_cfg_t make_pi(double kp, double ki, double ki_power, const char *key, double bandwidth)
{
    const char *const reason = "more is beyond the firmware's gains";
    const Mantissa p = normalise(kp, 1, 30, {key, bandwidth}, reason);
    const Mantissa i = normalise(std::ldexp(ki, 11), 1, 30, {key, bandwidth, ki_power}, reason);
    pi_cfg_t c{};
    c.kp = p.value;
    c.kp_shift = p.shift;
    c.ki = i.value;
    c.ki_shift = i.shift;
    return c;
}

} // namespace nf
