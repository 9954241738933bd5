/* SPDX-License-Identifier: MIT */
// What the firmware's integers mean in SI units, and the twins' parameters made of them.
//
// A twin gets the parameters that the integers stand for, not those they were rounded from: a
// comparison then shows the roundings of the arithmetic alone.
#pragma once

#include "firmware.h"
#include "per_unit.h"
#include "twin_current_loop.h"
#include "twin_motion_loop.h"
#include "twin_nn_observer.h"
#include "twin_phase_compensator.h"
#include "twin_pi.h"
#include "twin_torque_filter.h"
#include "twin_virtual_resistance.h"

#include <cmath>
#include <cstdint>

namespace nf::twin
{

constexpr double TWO_PI = 6.283185307179586476925;
constexpr double STEPS_PER_TURN = 4294967296.0;
constexpr double Q13 = 8192.0;
constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q27 = 134217728.0;
constexpr double SINE_LSB =
    1.0 / Q15; // |sin| and |cos| are at most 32767, within 1 LSB of 32767 of theirs

// The firmware's numbers, with the SI meaning of one.
struct PerUnit {
    double current(double q15) const
    {
        return q15 / Q15 * bases.current_a;
    }
    double voltage(double q15) const
    {
        return q15 / Q15 * bases.voltage_v;
    }
    double speed_of_step(double step) const
    {
        return step / STEPS_PER_TURN * TWO_PI / bases.control_period_s;
    }
    double step_of_speed(double rad_s) const
    {
        return rad_s * bases.control_period_s / TWO_PI * STEPS_PER_TURN;
    }
    double speed_of_q15(double q15) const
    {
        return q15 / Q15 * bases.speed_el_rad_s;
    }
    Vector current(const dq_t &i) const
    {
        return {current(i.d), current(i.q)};
    }
    Vector voltage(const ab_t &v) const
    {
        return {voltage(v.alpha), voltage(v.beta)};
    }
    Vector voltage(const dq_t &v) const
    {
        return {voltage(v.d), voltage(v.q)};
    }
    // I_x, base of the observer's states.
    double state_base() const
    {
        return std::ldexp(bases.current_a, static_cast<int>(cfg.observer.current_shift));
    }

    Bases bases;
    drive_cfg_t cfg;
};

// The bases are what one per unit of output and input means.
inline Pi::Params pi_params(const pi_cfg_t &c, double output_base, double input_base)
{
    const double scale = output_base / input_base;
    return {std::ldexp(c.kp, -static_cast<int>(c.kp_shift)) * scale,
            std::ldexp(c.ki, -static_cast<int>(c.ki_shift) - 11) * scale, output_base};
}

inline NnObserver::Params observer_params(const PerUnit &s)
{
    const nn_observer_cfg_t &c = s.cfg.observer;
    const double weight = std::ldexp(1.0, -12 - static_cast<int>(c.weight_shift));
    const double period = s.bases.control_period_s;
    const double base_x = s.state_base();
    const double ld = period / (c.volt_gain * weight) * s.bases.voltage_v / base_x;
    const double flux_current = c.flux_q27 / Q27 * base_x;
    // From b in A² to steps: b/(I_b·I_x)·2^30/2^gradient_shift·mantissa/2^shift; steps to radians a
    // sample.
    const double gradient = std::ldexp(1.0, 30 - static_cast<int>(c.gradient_shift)) /
                            (s.bases.current_a * base_x) * TWO_PI / STEPS_PER_TURN;

    NnObserver::Params p{};
    p.period_s = period;
    p.inductance_d_h = ld;
    p.inductance_q_h = ld * Q14 / c.iq_gain_q14;
    const double error_decay = c.decay * weight * base_x / s.bases.current_a;
    p.feedback = error_decay * c.feedback_q15 / Q15;
    p.resistance_ohm = (error_decay - p.feedback) / period * ld;
    p.flux_wb = flux_current * ld;
    p.eta = std::ldexp(c.eta, -static_cast<int>(c.eta_shift)) * gradient;
    p.saliency = c.saliency_q13 / Q13;
    p.corner_rad_s = s.speed_of_step(c.corner);
    p.rho_max = c.rho_max_q13 / Q13;
    p.rho_speed_min = s.speed_of_step(c.rho_speed_min);
    p.alpha = c.momentum_q15 / Q15;
    p.kappa_p = std::ldexp(c.kappa_p, -static_cast<int>(c.kappa_p_shift)) * gradient *
                flux_current * flux_current;
    return p;
}

inline CurrentLoop::Params current_loop_params(const PerUnit &s)
{
    const current_loop_cfg_t &c = s.cfg.current_loop;
    const double resistance = s.bases.voltage_v / s.bases.current_a;
    const double reactance = resistance / s.bases.speed_el_rad_s / Q13;
    return {pi_params(c.pi_d, s.bases.voltage_v, s.bases.current_a),
            pi_params(c.pi_q, s.bases.voltage_v, s.bases.current_a),
            c.reactance_d_q13 * reactance,
            c.reactance_q_q13 * reactance,
            c.emf_q13 / Q13 * s.bases.voltage_v / s.bases.speed_el_rad_s,
            c.resistance_q13 / Q13 * resistance};
}

// The speed error is Q15 of a base of its own: one is 2^(15 + error_shift) steps.
inline double speed_error_base(const PerUnit &s)
{
    return s.speed_of_step(std::ldexp(Q15, static_cast<int>(s.cfg.speed_loop.error_shift)));
}

// Of the PI that sets the magnitude of a voltage, V.
inline Pi::Params voltage_pi_params(const PerUnit &s)
{
    return pi_params(s.cfg.voltage_drive.pi, s.bases.voltage_v, speed_error_base(s));
}

// Currents in A.
inline PhaseCompensator::Params phase_compensator_params(const PerUnit &s)
{
    const phase_compensator_cfg_t &c = s.cfg.voltage_drive.compensator;
    const double radian = TWO_PI / STEPS_PER_TURN;
    return {std::ldexp(c.gain, -16 - static_cast<int>(c.gain_shift)), c.lead_max * radian,
            c.brake_max * radian, s.current(c.current_min)};
}

inline TorqueFilter::Params torque_filter_params(const torque_filter_cfg_t &c)
{
    return {c.smooth_rate_q15 / Q15, c.notch_share_q15 / Q15,
            std::complex<double>(c.notch_turn.cos, c.notch_turn.sin) / Q15};
}

// Currents in A, voltages in V.
inline VirtualResistance::Params virtual_resistance_params(const PerUnit &s)
{
    const virtual_resistance_cfg_t &c = s.cfg.voltage_drive.damping;
    return {c.resistance_q15 / Q15 * s.bases.voltage_v / s.bases.current_a, c.mean_rate_q15 / Q15};
}

inline SpeedLoop::Params speed_loop_params(const PerUnit &s)
{
    const speed_loop_cfg_t &c = s.cfg.speed_loop;
    const double per_step = std::ldexp(c.inertia, static_cast<int>(c.inertia_lift) - 16 -
                                                      static_cast<int>(c.inertia_shift)) /
                            Q15 * s.bases.current_a;
    return {pi_params(c.pi, s.bases.current_a, speed_error_base(s)),
            s.speed_of_step(c.ramp),
            s.speed_of_step(c.speed_max),
            -s.current(s.cfg.derating.current_max),
            s.current(s.cfg.derating.current_max),
            per_step / s.speed_of_step(1.0)};
}

inline double radians_of_q32(double q32)
{
    return q32 / STEPS_PER_TURN * TWO_PI;
}

inline PositionLoop::Params position_loop_params(const PerUnit &s)
{
    const position_loop_cfg_t &c = s.cfg.position_loop;
    const double unit = std::ldexp(1.0, static_cast<int>(c.distance_shift));
    const double gain = std::ldexp(c.gain, -static_cast<int>(c.gain_shift)); // steps per 2^-16 turn
    return {s.bases.control_period_s * s.cfg.slow_ticks,
            s.speed_of_step(c.ramp),
            s.speed_of_step(c.speed_max),
            radians_of_q32(1073741824.0 / c.braking_inverse * unit),
            c.softness_q15 / Q15,
            s.speed_of_step(gain) * 65536.0 / TWO_PI,
            TWO_PI / 2.0};
}

} // namespace nf::twin
