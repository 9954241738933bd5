// SPDX-License-Identifier: MIT
#include "hold_loop_units.h"

#include "imposed_current.h"
#include "modulator_units.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Damping wanted of the rotor's swing, and the slow integral that sets the mean current, per ω_n.
// Where R is more than that damping asks for, a negative K_p takes this share of R off. A winding
// of 0.7 of the file's R keeps 0.4 of its own.
constexpr double HOLD_DAMPING = 0.7;
constexpr double HOLD_INTEGRAL = 0.2;
constexpr double HOLD_RELIEF = 0.4;

// The dead-time compensation is off by up to 0.14 of what a leg loses, and by more the smaller the
// current is.
constexpr double HOLD_LOSS_SHARE = 0.2;

constexpr double PI_GAIN_MAX = 16000; // of a gain that no file writes: within make_pi's format

} // namespace

double hold_gain_ohm(const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning, const ModelScales &scales, const Model &m)
{
    const double current = hold_current(motor, board, tuning);
    const double swing = swing_rad_s(motor, board, tuning, m);
    const double loss_v = leg_loss_v(board, scales.dead_time_s, scales.device_drop_v);
    const double wanted =
        std::max({swing * active_share(current, motor) * m.flux / (2 * HOLD_DAMPING * current),
                  swing * m.inductance_q, HOLD_LOSS_SHARE * loss_v / current});
    return std::max(wanted - m.resistance, -HOLD_RELIEF * m.resistance);
}

current_loop_cfg_t make_hold_loop(const current_loop_cfg_t &run_loop, const MotorSettings &motor,
                                  const BoardSettings &board, const TuningSettings &tuning,
                                  const ModelScales &scales, const Model &m, const Bases &b)
{
    current_loop_cfg_t c = run_loop;
    if (tuning.startup_current_pct > 0) {
        const double swing = swing_rad_s(motor, board, tuning, m);
        const double kp = hold_gain_ohm(motor, board, tuning, scales, m);
        const double ki = (m.resistance + kp) * HOLD_INTEGRAL * swing * b.control_period_s;
        const double base = b.voltage_v / b.current_a;
        c.pi_d = make_pi(std::min(std::abs(kp) / base, PI_GAIN_MAX),
                         std::min(ki / base, PI_GAIN_MAX / 2048), 1, "startup.current_pct",
                         tuning.startup_current_pct);
        c.pi_d.kp *= kp < 0 ? -1 : 1;
        c.pi_q = c.pi_d;
    }
    return c;
}

} // namespace nf
