/* SPDX-License-Identifier: MIT */
// How far one tick of the firmware's observer may be from its twin: the roundings of its
// arithmetic, each at its worst.
#pragma once

#include "twin_params.h"

namespace nf::twin
{

// Sine and cosine enter both products of a rotated axis, each within 2 of 2^15: 1 of its amplitude,
// 1 of its rounding.
inline double turn_error(const Vector &v)
{
    return 2 * SINE_LSB * v.cwiseAbs().sum();
}

// Roundings of the firmware's î_d and î_q in A: the state turned into the frame, rounded down to a
// LSB; i_q scaled by L_d/L_q before that, another.
inline Vector output_roundings(const PerUnit &s, const Vector &state)
{
    const double turned = turn_error(state) + 3 * s.state_base() / Q27;
    return Vector(s.current(1) + turned, 2 * s.current(1) + turned);
}

// Roundings of one tick of the network, A of x and y, given the error before it. The change of a
// state is rounded down, 1 unit of Q27 in each stationary axis. What decays has the roundings of î,
// of the share of the measured current, of its turn by h = Δ/2 (h in Q15 from speeds in 2^14 steps,
// the products rounded down) and of its turn into the stationary frame.
inline Vector network_roundings(const PerUnit &s, const NnObserver &twin, double speed,
                                const Vector &state, const Vector &error)
{
    const double h = std::abs(speed) * s.bases.control_period_s / 2;
    const Vector drop = twin.drop(state, error);
    const double of_measured = s.cfg.observer.feedback_q15 == 0 ? 0 : 2;
    const double taken = output_roundings(s, state).sum() + (2 + h + of_measured) * s.current(1);
    return Vector::Constant(twin.error_decay()(0, 0) * taken + drop.norm() * 2 / Q15 +
                            turn_error(drop) + 1.4143 * s.state_base() / Q27);
}

// The drop's turn by half a step, 1 − jh, is h²/2 longer than the exact one and h³/3 off: A in each
// tick.
inline double half_turn_error(const PerUnit &s, const NnObserver &twin, double speed,
                              const Vector &state, const Vector &error)
{
    const double h = std::abs(speed) * s.bases.control_period_s / 2;
    return twin.drop(state, error).norm() * (h * h / 2 + h * h * h / 3);
}

// b = e'_q·x − e'_d·y as a function of e around a steady state, where e is small.
inline Eigen::RowVector2d effect_on_gradient(const NnObserver::Params &p, double rho,
                                             const Vector &state)
{
    Eigen::Matrix2d turn;
    turn << 1.0, rho * p.saliency, -rho, p.saliency;
    return Eigen::RowVector2d(-state.y(), state.x()) * turn;
}

// Roundings of e_d, e_q, b, ΔW2 and ω_out, in A, A², rad and rad/s. Of b: the error of i_q scaled 1
// LSB, turned and added 1 in each axis; b >> gradient_shift; x, y in b turned and rounded down to
// Q15 of I_x, times the error. ΔW2 rounded down to a step, its momentum to two; ω_out to a step.
inline Eigen::Matrix<double, 5, 1> training_roundings(const PerUnit &s, const NnObserver::Params &p,
                                                      double rho, const Vector &state,
                                                      double largest_error)
{
    const double lsb = s.current(1);
    const double base_x = s.state_base();
    const Vector size = state.cwiseAbs();
    const double scaled = size.x() + std::abs(rho) * size.y();
    const double step = s.speed_of_step(1);
    Eigen::Matrix<double, 5, 1> r;
    r << output_roundings(s, state),
        lsb * (scaled + size.x() + size.y()) +
            std::ldexp(lsb, static_cast<int>(s.cfg.observer.gradient_shift)) * base_x / Q15 +
            2.0 * largest_error * (base_x / Q15 + turn_error(state)),
        (p.alpha > 0 ? 3.0 : 1.0) * step * p.period_s, step;
    return r;
}

} // namespace nf::twin
