// SPDX-License-Identifier: MIT
#include "oscillation_units.h"

#include "motor_model.h"
#include "numbers.h"
#include "speed_margin.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The longest half-wave of a swing: what is slower is the load's or a position that hunts.
constexpr double HALF_WAVE_S = 0.5;
constexpr double HALF_WAVE_PERIODS = 60000; // what the firmware counts to

} // namespace

oscillation_cfg_t make_oscillation(const MotorSettings &motor, const TuningSettings &tuning,
                                   const Bases &b)
{
    const double slow_period_s = b.control_period_s * tuning.slow_ticks;
    oscillation_cfg_t c{};
    c.act = static_cast<uint32_t>(tuning.oscillation);
    c.halves_max = static_cast<uint32_t>(tuning.oscillation_half_waves);
    c.periods_max =
        static_cast<uint32_t>(std::clamp(HALF_WAVE_S / slow_period_s, 2.0, HALF_WAVE_PERIODS));
    const double amplitude = tuning.oscillation_amplitude_pct / 100 * continuous_current(motor);
    if (tuning.oscillation != OscillationAct::off) {
        require(amplitude, 0, motor.max_current_a,
                {"supervision.oscillation_amplitude_pct", tuning.oscillation_amplitude_pct},
                "motor.max_current_a: the torque current does not swing further");
    }
    keep(c.lag_periods_q4, 16 / (speed_lag_hz(tuning, b.control_period_s) * slow_period_s), 1, 1e6);
    keep(c.amplitude_max, amplitude / b.current_a * Q15, 1, Q14 - 1);
    return c;
}

} // namespace nf
