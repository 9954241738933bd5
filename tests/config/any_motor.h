/* SPDX-License-Identifier: MIT */
// Motors and boards as there are: drawn at random with the proportions of real machines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace test
{

// The same sequence on every machine, as the distributions of the standard library are not.
class Draw
{
public:
    explicit Draw(uint64_t seed) : state_(seed)
    {
    }

    double uniform(double lo, double hi)
    {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return lo + (hi - lo) * static_cast<double>(state_ >> 11U) / 9007199254740992.0;
    }

    double log_uniform(double lo, double hi)
    {
        return lo * std::pow(hi / lo, uniform(0, 1));
    }

    std::size_t below(std::size_t count)
    {
        return static_cast<std::size_t>(uniform(0, static_cast<double>(count)));
    }

private:
    uint64_t state_;
};

// KEY=VALUE of a motor and of a board that goes with it: 1 to 25 pole pairs, 8 to 40 kHz, 5 W to 15 kW.
inline std::vector<std::string> any_motor(Draw &draw)
{
    const double rad_s_per_rpm = 3.14159265358979323846 / 30;
    const double power_w = draw.log_uniform(5, 15000);
    const double frequency_hz = std::round(draw.log_uniform(8000, 40000));
    const int pole_pairs = static_cast<int>(std::round(draw.log_uniform(1, 25)));
    const double bus_v = power_w < 1000 ? draw.log_uniform(12, 60) : draw.log_uniform(300, 600);
    // At least 30 PWM periods in an electrical turn at the highest speed.
    const double turns_s = std::min(frequency_hz / 30, draw.log_uniform(30, 800));
    const double max_rpm = 60 * turns_s / pole_pairs;
    const double rated_rpm = max_rpm / draw.uniform(1.05, 1.4);
    const double max_el = max_rpm * rad_s_per_rpm * pole_pairs;
    const double flux = draw.uniform(0.5, 0.9) * bus_v / std::sqrt(3.0) / max_el;
    const double torque = power_w / (rated_rpm * rad_s_per_rpm);
    const double current = torque / (1.5 * pole_pairs * flux);
    const double max_current = current * draw.uniform(1.2, 3);
    const double resistance = draw.log_uniform(0.02, 0.3) * power_w / (1.5 * current * current);
    const double inductance = draw.log_uniform(0.02, 0.5) * flux / current;
    const double start_s = draw.log_uniform(0.01, 1); // from rest to rated speed with rated torque
    const double overcurrent = max_current * draw.uniform(1.15, 1.6);
    const auto line = [](const char *key, double value) {
        return fmt::format("{}={:.6g}", key, value);
    };
    return {
        fmt::format("motor.pole_pairs={}", pole_pairs),
        line("motor.resistance_ohm", std::clamp(resistance, 0.001, 50.0)),
        line("motor.inductance_d_h", inductance),
        line("motor.inductance_q_h", inductance * draw.uniform(1, 2)),
        line("motor.flux_linkage_wb", flux),
        line("motor.rated_torque_nm", torque),
        line("motor.rated_speed_rpm", rated_rpm),
        line("motor.max_speed_rpm", max_rpm),
        line("motor.max_current_a", max_current),
        line("motor.inertia_kg_m2", std::max(1e-7, torque * start_s / (rated_rpm * rad_s_per_rpm))),
        "motor.viscous_friction_nm_s=0",
        line("board.pwm_frequency_hz", frequency_hz),
        line("board.overcurrent_a", overcurrent),
        line("board.current_full_scale_a", overcurrent * draw.uniform(1.1, 2)),
        "board.offset_max_a=" + fmt::format("{:.6g}", 0.03 * overcurrent),
        line("board.bus_full_scale_v", bus_v * draw.uniform(1.35, 2)),
        line("board.bus_nominal_v", bus_v),
        line("board.bus_min_v", bus_v * draw.uniform(0.4, 0.7)),
        line("board.bus_max_v", bus_v * draw.uniform(1.15, 1.3)),
        line("board.dead_time_s", draw.uniform(0.2e-6, 2e-6)),
    };
}

} // namespace test
