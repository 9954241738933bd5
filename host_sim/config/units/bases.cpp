// SPDX-License-Identifier: MIT
#include "bases.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The converter's full scale is half the current base, so that no vector of three currents
// overflows.
constexpr double CURRENT_BASE_RATIO = 2.0;

// The estimate may overshoot the highest speed asked for.
constexpr double ESTIMATE_HEADROOM = 1.25;

constexpr double PERIODS_MAX = 60000; // what a counter of slow periods is set to at most
constexpr double TICKS_MAX = 1048576;

double speed_base(const Bases &b)
{
    return std::ldexp(Q15, b.speed_shift) / STEPS_PER_TURN * TWO_PI / b.control_period_s;
}

} // namespace

double Bases::torque_nm() const
{
    return BUS_CURRENT_FACTOR * pole_pairs * voltage_v * current_a / speed_el_rad_s;
}

double Bases::step_from_rpm(double rpm) const
{
    return rad_s_from_rpm(rpm) * pole_pairs * control_period_s / TWO_PI * STEPS_PER_TURN;
}

double Bases::rpm_from_step(double step) const
{
    return step / step_from_rpm(1.0);
}

double Bases::position_max_turns() const
{
    constexpr double ELECTRICAL = 32767; // Q16 in 32 bits
    return std::floor(ELECTRICAL / pole_pairs);
}

double Bases::turns_from_mech_rad(double rad) const
{
    return rad * pole_pairs / TWO_PI;
}

Bases make_bases(const MotorSettings &motor, const BoardSettings &board)
{
    Bases b{};
    b.control_period_s = 1.0 / board.pwm_frequency_hz;
    b.current_a = board.current_full_scale_a * CURRENT_BASE_RATIO;
    b.voltage_v = board.bus_full_scale_v;
    b.pole_pairs = motor.pole_pairs;
    keep(b.speed_limit, b.step_from_rpm(motor.max_speed_rpm) * ESTIMATE_HEADROOM, 1, Q30 / 2);
    b.speed_shift = 1;
    while (std::ldexp(Q15, b.speed_shift) <= b.speed_limit) {
        b.speed_shift++;
    }
    b.speed_el_rad_s = speed_base(b);
    return b;
}

Bases rescaled(Bases bases, const drive_cfg_t &cfg)
{
    bases.speed_shift = static_cast<int>(cfg.speed_shift);
    bases.speed_el_rad_s = speed_base(bases);
    return bases;
}

int32_t current_q15(double current_a, const Bases &b)
{
    return static_cast<int32_t>(std::lround(current_a / b.current_a * Q15));
}

uint32_t ticks(double seconds, const Bases &b)
{
    return static_cast<uint32_t>(
        std::clamp(std::ceil(seconds / b.control_period_s), 1.0, TICKS_MAX));
}

uint32_t slow_periods(double seconds, const TuningSettings &tuning, const Bases &b)
{
    return static_cast<uint32_t>(
        std::clamp(std::ceil(seconds / b.control_period_s / tuning.slow_ticks), 1.0, PERIODS_MAX));
}

} // namespace nf
