// SPDX-License-Identifier: MIT
#include "sampling_units.h"

#include <cmath>

namespace nf
{

sampling_cfg_t make_sampling(const MotorSettings &motor, const BoardSettings &board,
                             const TuningSettings &tuning)
{
    sampling_cfg_t c{};
    if (tuning.angle_source != AngleSource::observer) {
        const bool is_electrical = motor.sensor.kind == SensorKind::hall;
        c.sensor_pole_pairs = is_electrical ? 1U : static_cast<uint32_t>(motor.pole_pairs);
    }
    c.current_shift = static_cast<uint32_t>(15 - board.adc_bits);
    c.bus_shift = c.current_shift;
    c.offset_log2 = static_cast<uint32_t>(board.offset_samples_log2);
    return c;
}

double calibration_time(const BoardSettings &board, const TuningSettings &tuning)
{
    return (std::exp2(board.offset_samples_log2) + 1 + tuning.slow_ticks) / board.pwm_frequency_hz;
}

TuningSettings for_sensor(const TuningSettings &tuning)
{
    TuningSettings t = tuning;
    if (t.angle_source == AngleSource::sensor) {
        t.startup_current_pct = 0;
        t.observer_kappa = 0;
        t.observer_kappa_p = 0;
        t.observer_momentum = 0;
        t.observer_acceleration = 0;
        t.pace_speed_pct = 0;
        t.kappa_speed_pct = 0;
    }
    return t;
}

} // namespace nf
