// SPDX-License-Identifier: MIT
#include "dimensionless.h"

#include "modulator_units.h"
#include "motor_model.h"
#include "nn_observer_units.h"
#include "numbers.h"
#include "per_unit.h"

namespace nf
{
namespace
{

// What all of them are made of, in SI units.
struct Ratings {
    double period_s;
    double current_a;
    double omega;
    double emf_v;
    double inductance_h; // the mean of both axes
    double swing;        // rad/s, of a standing rotor in the field of the rated current
    double stop_s;       // from rated speed to rest with rated torque
};

Ratings ratings_of(const Config &config)
{
    const MotorSettings &motor = config.motor;
    Ratings r{};
    r.period_s = 1 / config.board.pwm_frequency_hz;
    r.current_a = rated_current(motor);
    r.omega = rad_s_from_rpm(motor.rated_speed_rpm) * motor.pole_pairs;
    r.emf_v = r.omega * motor.flux_linkage_wb;
    r.inductance_h = (motor.inductance_d_h + motor.inductance_q_h) / 2;
    r.swing = std::sqrt(motor.pole_pairs * motor.rated_torque_nm / motor.inertia_kg_m2);
    r.stop_s = rad_s_from_rpm(motor.rated_speed_rpm) * motor.inertia_kg_m2 / motor.rated_torque_nm;
    return r;
}

// Of the voltage circle, with half of the rated torque at rated speed.
double voltage_use(const Config &config, const Ratings &r)
{
    const double current = r.current_a / 2;
    const double along_q = r.emf_v + config.motor.resistance_ohm * current;
    const double along_d = r.omega * config.motor.inductance_q_h * current;
    return std::sqrt(along_q * along_q + along_d * along_d) /
           (largest_ratio(config.board) * config.board.bus_nominal_v);
}

} // namespace

std::vector<Dimensionless> dimensionless(const Config &config)
{
    const MotorSettings &motor = config.motor;
    const BoardSettings &board = config.board;
    const TuningSettings tuning = settled_tuning(motor, board, config.tuning, config.model);
    const Ratings r = ratings_of(config);
    const double lsb_a = std::ldexp(board.current_full_scale_a, 1 - board.adc_bits);
    const double handover = tuning.handover_speed_pct / 100 * r.omega;
    const double drop_v = motor.resistance_ohm * r.current_a;
    const double loss_v = leg_loss_v(board, config.plant.dead_time_s, config.plant.device_drop_v);
    const double ripple_a = board.bus_nominal_v * r.period_s / (12 * r.inductance_h);
    return {
        {"speed_lag", "2πf·κ_p/κ·T: the speed loop's bandwidth times the lag of the estimate",
         TWO_PI * tuning.speed_bandwidth_hz * estimate_lag_s(tuning, r.period_s)},
        {"ramp_lag", "speed that the ramp gains in the lag of the estimate, of rated speed",
         tuning.speed_ramp_rpm_s * estimate_lag_s(tuning, r.period_s) / motor.rated_speed_rpm},
        {"current_loop", "2πf·T of the current loop",
         TWO_PI * tuning.current_bandwidth_hz * r.period_s},
        {"dead_time", "voltage of dead time and device drop over R·I", loss_v / drop_v},
        {"dead_time_emf", "likewise over the EMF at the hand-over",
         loss_v / (handover * motor.flux_linkage_wb)},
        {"copper", "R·I over the EMF at rated speed", drop_v / r.emf_v},
        {"reactance", "ωLI over the EMF", r.omega * r.inductance_h * r.current_a / r.emf_v},
        {"decay", "R·T/L", motor.resistance_ohm * r.period_s / r.inductance_h},
        {"turn", "ω·T at the highest speed",
         rad_s_from_rpm(motor.max_speed_rpm) * motor.pole_pairs * r.period_s},
        {"saliency", "L_q/L_d", motor.inductance_q_h / motor.inductance_d_h},
        {"converter", "LSB of the current over I", lsb_a / r.current_a},
        {"pwm_ripple", "ripple of a PWM period over I", ripple_a / r.current_a},
        {"voltage", "voltage at rated speed and half torque, of the largest",
         voltage_use(config, r)},
        {"swing", "the rotor's own swing in the imposed field over the hand-over speed",
         r.swing / handover},
        {"inertia", "time to stop from rated speed with rated torque, PWM periods",
         r.stop_s / r.period_s},
        {"overcurrent", "limit of the over-current protection over the largest current",
         board.overcurrent_a / motor.max_current_a},
    };
}

} // namespace nf
