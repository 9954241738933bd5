// SPDX-License-Identifier: MIT
#include "current_loop_units.h"

#include "model_units.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The current PI integrates at least this much faster than the motor's own R/L would: disturbances
// (dead time, EMF error) decay within ten times the closed-loop time constant.
constexpr double INTEGRAL_RATIO = 0.1;

// A gain that can still grow by `headroom`, as far as there is room.
void leave_room(int32_t &mantissa, uint32_t &shift, double headroom)
{
    int bits = 0;
    while (static_cast<int>(shift) - bits > 1 &&
           std::ldexp(mantissa * headroom, -bits) > MANTISSA_MAX) {
        bits++;
    }
    mantissa = static_cast<int32_t>(std::lround(std::ldexp(mantissa, -bits)));
    shift -= static_cast<uint32_t>(bits);
}

// Pole of the closed loop at the bandwidth, zero of the PI on the motor's R/L or INTEGRAL_RATIO
// above.
pi_cfg_t make_current_pi(const TuningSettings &tuning, const Model &m, const Bases &b,
                         double inductance)
{
    const double omega = TWO_PI * tuning.current_bandwidth_hz;
    const double kp = omega * inductance * b.current_a / b.voltage_v;
    const double own = m.resistance / inductance;
    const double corner = std::max(own, omega * INTEGRAL_RATIO);
    pi_cfg_t c = make_pi(kp, kp * corner * b.control_period_s, corner > own ? 2 : 1,
                         "current_loop.bandwidth_hz", tuning.current_bandwidth_hz);
    const double headroom = model_headroom(tuning).inductance;
    leave_room(c.kp, c.kp_shift, headroom);
    leave_room(c.ki, c.ki_shift, headroom);
    return c;
}

} // namespace

current_loop_cfg_t make_current_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                     const Model &m, const Bases &b)
{
    const double reactance = b.speed_el_rad_s * b.current_a / b.voltage_v * Q13;
    current_loop_cfg_t c{};
    c.pi_d = make_current_pi(tuning, m, b, m.inductance_d);
    c.pi_q = make_current_pi(tuning, m, b, m.inductance_q);
    keep(c.reactance_d_q13, reactance * m.inductance_d, 0, MANTISSA_MAX);
    keep(c.reactance_q_q13, reactance * m.inductance_q, 0, MANTISSA_MAX);
    keep(c.emf_q13, b.speed_el_rad_s * m.flux / b.voltage_v * Q13, 0, MANTISSA_MAX);
    store(c.resistance_q13, m.resistance * b.current_a / b.voltage_v * Q13, 0, MANTISSA_MAX,
          {"motor.resistance_ohm", motor.resistance_ohm},
          "twice board.bus_full_scale_v over board.current_full_scale_a; a board for smaller "
          "currents takes this motor");
    return c;
}

} // namespace nf
