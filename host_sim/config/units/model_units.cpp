// SPDX-License-Identifier: MIT
#include "model_units.h"

#include "numbers.h"

#include <cmath>

namespace nf
{
namespace
{

constexpr double FLUX_TIME_S = 0.05;
constexpr double FLUX_SPEED_SHARE = 0.2; // of rated speed

gain_share_cfg_t make_gain_share(double full_speed, double least)
{
    gain_share_cfg_t c{};
    c.least_q14 = static_cast<int32_t>(std::lround(least * Q14));
    keep(c.full_speed, full_speed, 0, Q30 / 4);
    int32_t mantissa = c.full_speed;
    while (mantissa >= Q14) {
        mantissa >>= 1;
        c.shift++;
    }
    if (mantissa > 0) {
        keep(c.gain, Q14 * Q14 / mantissa, 0, MANTISSA_MAX);
    }
    return c;
}

} // namespace

ModelHeadroom model_headroom(const TuningSettings &tuning)
{
    const double r = tuning.adapt_resistance_pct / 100;
    const double l = tuning.adapt_inductance_pct / 100;
    const double f = tuning.adapt_flux_pct / 100;
    const double s = tuning.adapt_saliency_pct / 100;
    return {(1 + r) / (1 - l), (1 + l) * (1 + l), (1 + f) / (1 - l), 1 + s, (1 + l) * (1 + s)};
}

model_cfg_t make_model_cfg(const MotorSettings &motor, const TuningSettings &tuning, const Model &m,
                           const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    model_cfg_t c{};
    c.resistance_limit_q14 =
        static_cast<int32_t>(std::lround(tuning.adapt_resistance_pct / 100 * Q14));
    c.inductance_limit_q14 =
        static_cast<int32_t>(std::lround(tuning.adapt_inductance_pct / 100 * Q14));
    c.saliency_limit_q14 = static_cast<int32_t>(std::lround(tuning.adapt_saliency_pct / 100 * Q14));
    c.flux_limit_q14 = static_cast<int32_t>(std::lround(tuning.adapt_flux_pct / 100 * Q14));
    keep(c.flux_rate, slow_period / FLUX_TIME_S * b.current_a / m.flux_current * Q15, 0,
         MANTISSA_MAX);
    keep(c.flux_speed_min, b.step_from_rpm(motor.rated_speed_rpm * FLUX_SPEED_SHARE), 0, Q30 / 2);
    const double rated = b.step_from_rpm(motor.rated_speed_rpm);
    c.pace = make_gain_share(tuning.pace_speed_pct / 100 * rated, tuning.pace_least);
    c.kappa = make_gain_share(tuning.kappa_speed_pct / 100 * rated, tuning.kappa_least);
    return c;
}

} // namespace nf
