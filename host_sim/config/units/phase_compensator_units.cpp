// SPDX-License-Identifier: MIT
#include "phase_compensator_units.h"

#include "motor_model.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{

phase_compensator_cfg_t make_compensator(const MotorSettings &motor, const TuningSettings &tuning,
                                         const Bases &b)
{
    const Mantissa g = normalise(std::ldexp(tuning.compensator_gain, 16), 0, 15,
                                 {"phase_compensator.gain", tuning.compensator_gain},
                                 "half of the angle in a sample");
    const auto angle = [](double degrees) {
        return static_cast<int32_t>(std::lround(degrees / 360 * STEPS_PER_TURN));
    };
    const double current = tuning.compensator_current_pct / 100 * continuous_current(motor);
    phase_compensator_cfg_t c{};
    c.gain = g.value;
    c.gain_shift = g.shift;
    c.lead_max = angle(tuning.lead_max_deg);
    c.brake_max = angle(tuning.brake_max_deg);
    c.current_min = static_cast<int32_t>(
        std::lround(std::clamp(current / b.current_a * Q15, 1.0, MANTISSA_MAX)));
    return c;
}

} // namespace nf
