// SPDX-License-Identifier: MIT
#include "torque_loop_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr int LOAD_SHIFT_MAX = 14;

// The load is known as fast as the speed loop finds it: K_p/K_i, in slow periods, as a power of
// two.
uint32_t load_shift(const pi_cfg_t &pi)
{
    if (pi.ki == 0 || pi.kp == 0) {
        return LOAD_SHIFT_MAX;
    }
    const double periods =
        std::ldexp(static_cast<double>(pi.kp) / pi.ki, static_cast<int>(pi.ki_shift) +
                                                           static_cast<int>(PI_INTEGRAL_BITS) -
                                                           static_cast<int>(pi.kp_shift));
    return static_cast<uint32_t>(
        std::clamp(std::lround(std::log2(periods)), 0L, static_cast<long>(LOAD_SHIFT_MAX)));
}

// An end of the window of speeds; below 0: that of the motor.
step_t window_end(const char *key, double rpm, const MotorSettings &motor,
                  const speed_loop_cfg_t &speed_loop, const Bases &b)
{
    if (rpm < 0) {
        return speed_loop.speed_max;
    }
    require({key, rpm}, 0, motor.max_speed_rpm, "motor.max_speed_rpm");
    return std::min(speed_loop.speed_max, static_cast<step_t>(std::lround(b.step_from_rpm(rpm))));
}

} // namespace

torque_loop_cfg_t make_torque_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                   const speed_loop_cfg_t &speed_loop, const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    torque_loop_cfg_t c{};
    keep(c.slope, tuning.torque_slope_nm_s * slow_period / b.torque_nm() * Q28, 1, Q30 / 2);
    c.speed_forward = window_end("torque_loop.speed_forward_rpm", tuning.torque_forward_rpm, motor,
                                 speed_loop, b);
    c.speed_backward = window_end("torque_loop.speed_backward_rpm", tuning.torque_backward_rpm,
                                  motor, speed_loop, b);
    c.load_shift = load_shift(speed_loop.pi);
    return c;
}

} // namespace nf
