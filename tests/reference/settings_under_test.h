// Configurations of both motors for the comparisons, and what the firmware's integers mean in SI units.
//
// A twin gets the parameters that the integers stand for, not those they were rounded from: a comparison
// then shows the roundings of the arithmetic alone.
#pragma once

#include "firmware.h"
#include "per_unit.h"
#include "twin_current_loop.h"
#include "twin_motion_loop.h"
#include "twin_nn_observer.h"
#include "twin_pi.h"

#include <cmath>
#include <cstdint>
#include <random>

namespace nf::reference
{

constexpr double TWO_PI = 6.283185307179586476925;
constexpr double STEPS_PER_TURN = 4294967296.0;
constexpr double Q13 = 8192.0;
constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q27 = 134217728.0;
constexpr double SINE_LSB =
    1.0 / Q15; // |sin| and |cos| are at most 32767, within 1 LSB of 32767 of theirs

inline MotorSettings motor_a()
{
    MotorSettings m;
    m.name = "A";
    m.pole_pairs = 2;
    m.resistance_ohm = 2.125;
    m.inductance_d_h = 0.0116;
    m.inductance_q_h = 0.0116;
    m.flux_linkage_wb = 0.387;
    m.rated_torque_nm = 7.8;
    m.rated_speed_rpm = 1800;
    m.max_speed_rpm = 2000;
    m.max_current_a = 10;
    m.inertia_kg_m2 = 0.003;
    return m;
}

inline MotorSettings motor_b()
{
    MotorSettings m;
    m.name = "B";
    m.pole_pairs = 2;
    m.resistance_ohm = 0.405;
    m.inductance_d_h = 0.0135;
    m.inductance_q_h = 0.0235;
    m.flux_linkage_wb = 0.375;
    m.rated_torque_nm = 4;
    m.rated_speed_rpm = 1200;
    m.max_speed_rpm = 1400;
    m.max_current_a = 8;
    m.inertia_kg_m2 = 0.011;
    return m;
}

inline BoardSettings board(double pwm_frequency_hz = 10000)
{
    BoardSettings b;
    b.name = "bench";
    b.pwm_frequency_hz = pwm_frequency_hz;
    b.timer_clock_hz = 170e6;
    b.adc_bits = 12;
    b.current_full_scale_a = 20;
    b.bus_full_scale_v = 450;
    b.bus_nominal_v = 310;
    b.bus_min_v = 200;
    b.bus_max_v = 400;
    b.overcurrent_a = 18;
    b.offset_max_a = 1;
    b.duty_margin_pct = 5;
    b.offset_samples_log2 = 8;
    return b;
}

inline TuningSettings tuning()
{
    TuningSettings t;
    t.name = "robust";
    t.observer_kappa = 0.005;
    t.observer_kappa_p = 0.1;
    t.current_bandwidth_hz = 500;
    t.speed_bandwidth_hz = 20;
    t.speed_damping = 1;
    t.speed_ramp_rpm_s = 10000;
    t.inertia_feed_forward = 1;
    t.position_bandwidth_hz = 5;
    t.position_speed_rpm = 900;
    t.position_acceleration_rad_s2 = 800;
    t.position_softness_s = 0.01;
    t.slow_ticks = 10;
    return t;
}

// The firmware's numbers for a motor, with the SI meaning of one.
struct Setup {
    Setup(const MotorSettings &motor, const BoardSettings &board, const TuningSettings &tuning)
        : bases(make_bases(motor, board)), cfg(make_drive_cfg(motor, board, tuning, no_losses()))
    {
    }

    // The motor as in its file, and an inverter without dead time and drop.
    static ModelScales no_losses()
    {
        ModelScales scales;
        scales.dead_time_s = 0;
        scales.device_drop_v = 0;
        return scales;
    }

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
    twin::Vector current(const dq_t &i) const
    {
        return {current(i.d), current(i.q)};
    }
    twin::Vector voltage(const ab_t &v) const
    {
        return {voltage(v.alpha), voltage(v.beta)};
    }
    twin::Vector voltage(const dq_t &v) const
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
inline twin::Pi::Params pi_params(const pi_cfg_t &c, double output_base, double input_base)
{
    const double scale = output_base / input_base;
    return {std::ldexp(c.kp, -static_cast<int>(c.kp_shift)) * scale,
            std::ldexp(c.ki, -static_cast<int>(c.ki_shift) - 11) * scale, output_base};
}

inline twin::NnObserver::Params observer_params(const Setup &s)
{
    const nn_observer_cfg_t &c = s.cfg.observer;
    const double weight = std::ldexp(1.0, -12 - static_cast<int>(c.weight_shift));
    const double period = s.bases.control_period_s;
    const double base_x = s.state_base();
    const double ld = period / (c.volt_gain * weight) * s.bases.voltage_v / base_x;
    const double flux_current = c.flux_q27 / Q27 * base_x;
    // From b in A² to steps: b/(I_b·I_x)·2^30/2^12·mantissa/2^shift; steps to radians a sample.
    const double descent = 262144.0 / (s.bases.current_a * base_x) * TWO_PI / STEPS_PER_TURN;

    twin::NnObserver::Params p{};
    p.period_s = period;
    p.inductance_d_h = ld;
    p.inductance_q_h = ld * Q14 / c.iq_gain_q14;
    p.resistance_ohm = c.decay * weight * base_x / s.bases.current_a / period * ld;
    p.flux_wb = flux_current * ld;
    p.eta = std::ldexp(c.rate, -static_cast<int>(c.rate_shift)) * descent;
    p.saliency = c.saliency_q13 / Q13;
    p.corner_rad_s = s.speed_of_step(c.corner);
    p.rho_max = c.rho_max_q13 / Q13;
    p.rho_speed_min = s.speed_of_step(c.rho_speed_min);
    p.alpha = c.momentum_q15 / Q15;
    p.kappa_p = std::ldexp(c.proportional, -static_cast<int>(c.proportional_shift)) * descent *
                flux_current * flux_current;
    return p;
}

inline twin::CurrentLoop::Params current_loop_params(const Setup &s)
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

inline twin::SpeedLoop::Params speed_loop_params(const Setup &s)
{
    const speed_loop_cfg_t &c = s.cfg.speed_loop;
    // The error is Q15 of a base of its own: one is 2^(15 + error_shift) steps.
    const double error_base = s.speed_of_step(std::ldexp(Q15, static_cast<int>(c.error_shift)));
    const double per_step =
        std::ldexp(c.inertia, -16 - static_cast<int>(c.inertia_shift)) / Q15 * s.bases.current_a;
    return {pi_params(c.pi, s.bases.current_a, error_base), s.speed_of_step(c.ramp),
            s.speed_of_step(c.speed_max), s.current(s.cfg.derating.current_max),
            per_step / s.speed_of_step(1.0)};
}

inline double radians_of_q32(double q32)
{
    return q32 / STEPS_PER_TURN * TWO_PI;
}

inline twin::PositionLoop::Params position_loop_params(const Setup &s)
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

// Seeded numbers, the same with every library: no distribution classes.
class Seeded
{
public:
    explicit Seeded(uint32_t seed) : engine_(seed)
    {
    }

    int32_t in(int32_t lo, int32_t hi)
    {
        const auto span = static_cast<uint64_t>(static_cast<int64_t>(hi) - lo) + 1U;
        return static_cast<int32_t>(
            lo + static_cast<int64_t>((static_cast<uint64_t>(engine_()) * span) >> 32U));
    }

private:
    std::mt19937 engine_;
};

} // namespace nf::reference
