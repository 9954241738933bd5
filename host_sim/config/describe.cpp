// SPDX-License-Identifier: MIT
#include "describe.h"

#include "numbers.h"

#include <cmath>
#include <type_traits>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr int PI_INTEGRAL_BITS = 11; // of pi_cfg_t: gain = ki / 2^(ki_shift + 11)

double scaled(std::int64_t value, int bits)
{
    return std::ldexp(static_cast<double>(value), -bits);
}

struct Rows {
    const Config &config;
    TuningSettings tuning; // with what it leaves to the motor
    const drive_cfg_t &built;
    Bases bases;
    std::vector<ConfigRow> rows;

    template <typename Number, typename... Arguments>
    void add(const std::string &path, Number value, fmt::format_string<Arguments...> meaning,
             Arguments &&...arguments)
    {
        rows.push_back({path, value, std::is_unsigned_v<Number>, sizeof value,
                        fmt::format(meaning, std::forward<Arguments>(arguments)...)});
    }

    double ampere(int32_t q15) const
    {
        return scaled(q15, 15) * bases.current_a;
    }

    double volt(int32_t q15) const
    {
        return scaled(q15, 15) * bases.voltage_v;
    }

    double supervision_period() const
    {
        return slow_period() * SUPERVISION_STEPS;
    }

    double slow_period() const
    {
        return bases.control_period_s * static_cast<double>(built.slow_ticks);
    }

    double seconds(uint32_t ticks) const
    {
        return bases.control_period_s * ticks;
    }

    double rpm(step_t steps) const
    {
        return bases.rpm_from_step(steps);
    }
};

void add_sampling(Rows &to)
{
    const sampling_cfg_t &c = to.built.sampling;
    to.add("sampling.current_shift", c.current_shift, "{} bit counts to Q15 of I_b = {:g} A",
           to.config.board.adc_bits, to.bases.current_a);
    to.add("sampling.bus_shift", c.bus_shift, "{} bit counts to Q15 of U_b = {:g} V",
           to.config.board.adc_bits, to.bases.voltage_v);
    to.add("sampling.offset_log2", c.offset_log2, "averages {:g} samples",
           std::exp2(c.offset_log2));
    to.add("sampling.sensor_pole_pairs", c.sensor_pole_pairs,
           "electrical turns in one of the angle sensor; 0: none");
}

void add_protection(Rows &to)
{
    const protection_cfg_t &c = to.built.protection;
    to.add("protection.current_max", c.current_max, "{:.5g} A", to.ampere(c.current_max));
    to.add("protection.bus_max", c.bus_max, "{:.5g} V", to.volt(c.bus_max));
    to.add("protection.bus_min", c.bus_min, "{:.5g} V", to.volt(c.bus_min));
    to.add("protection.offset_max", c.offset_max, "{:.5g} A", to.ampere(c.offset_max));
}

// A share over x, `unit` being the value of one step of x.
void add_fade(Rows &to, const std::string &name, const fade_t &c, double unit, const char *symbol)
{
    if (c.gain == 0) {
        to.add(name + ".zero", c.zero, "not used");
        to.add(name + ".gain", c.gain, "no derating");
    } else {
        const double span = 32768.0 / scaled(c.gain, static_cast<int>(c.shift));
        to.add(name + ".zero", c.zero, "nothing left at {:.5g} {}", c.zero * unit, symbol);
        to.add(name + ".gain", c.gain, "everything at {:.5g} {}", (c.zero - span) * unit, symbol);
    }
    to.add(name + ".shift", c.shift, "of the gain");
}

void add_bus_current(Rows &to, const std::string &name, int32_t value)
{
    if (value == 0) {
        to.add(name, value, "no limit");
    } else {
        to.add(name, value, "{:.5g} A", BUS_CURRENT_FACTOR * to.ampere(value));
    }
}

void add_derating(Rows &to)
{
    const derating_cfg_t &c = to.built.derating;
    const double volt = to.bases.voltage_v / 32768.0;
    to.add("derating.current_max", c.current_max, "{:.5g} A", to.ampere(c.current_max));
    to.add("derating.current_continuous", c.current_continuous, "{:.5g} A",
           to.ampere(c.current_continuous));
    to.add("derating.heat_shift", c.heat_shift, "of the square");
    to.add("derating.heat_gain", c.heat_gain, "heat 1 at {:.5g} A",
           std::sqrt(std::ldexp(1.0, 40 - static_cast<int>(c.heat_shift)) / c.heat_gain) / 32768.0 *
               to.bases.current_a);
    to.add("derating.heat_rate", c.heat_rate, "time constant {:.4g} s",
           to.supervision_period() / scaled(c.heat_rate, 16 + static_cast<int>(c.heat_rate_shift)));
    to.add("derating.heat_rate_shift", c.heat_rate_shift, "of the rate");
    to.add("derating.heat_max_q14", c.heat_max_q14, "{:.4g} %", scaled(c.heat_max_q14, 14) * 100);
    add_fade(to, "derating.heat", c.heat, 100 / 16384.0, "%");
    add_fade(to, "derating.temperature", c.temperature, 1, "counts");
    to.add("derating.temperature_periods", c.temperature_periods, "{:.4g} s",
           c.temperature_periods * to.supervision_period());
    add_fade(to, "derating.bus_high", c.bus_high, volt, "V");
    add_fade(to, "derating.bus_low", c.bus_low, volt, "V");
    to.add("derating.regeneration_speed", c.regeneration_speed, "{:.5g} rpm",
           to.bases.rpm_from_step(c.regeneration_speed));
    add_bus_current(to, "derating.bus_current_max", c.bus_current_max);
    add_bus_current(to, "derating.bus_regeneration_max", c.bus_regeneration_max);
}

void add_supervision(Rows &to)
{
    const supervision_cfg_t &c = to.built.supervision;
    const auto ampere = [&](const std::string &name, int32_t value) {
        to.add("supervision." + name, value, "{:.4g} A", to.ampere(value));
    };
    const auto rpm = [&](const std::string &name, int32_t value) {
        to.add("supervision." + name, value, "{:.5g} rpm", to.bases.rpm_from_step(value));
    };
    const auto time = [&](const std::string &name, uint32_t value) {
        to.add("supervision." + name, value, "{:.4g} s", value * to.supervision_period());
    };
    ampere("phase_range_min", c.phase_range_min);
    ampere("phase_zero_max", c.phase_zero_max);
    rpm("phase_speed_max", c.phase_speed_max);
    to.add("supervision.swing_periods", c.swing_periods, "{:.4g} s",
           c.swing_periods * to.slow_period());
    to.add("supervision.voltage_max", c.voltage_max, "{:.4g} V", to.volt(c.voltage_max));
    ampere("follow_error_max", c.follow_error_max);
    ampere("residual_max", c.residual_max);
    to.add("supervision.mean_shift", c.mean_shift, "mean of {:.4g} s",
           std::ldexp(to.supervision_period(), static_cast<int>(c.mean_shift)));
    rpm("speed_error_max", c.speed_error_max);
    time("speed_error_periods", c.speed_error_periods);
    time("runaway_periods", c.runaway_periods);
    rpm("overspeed", c.overspeed);
    time("overspeed_periods", c.overspeed_periods);
    ampere("stall_current", c.stall_current);
    rpm("stall_speed", c.stall_speed);
    time("stall_periods", c.stall_periods);
    to.add("supervision.late_max", c.late_max, "late ticks");
    time("late_window", c.late_window);
}

void add_network(Rows &to)
{
    const nn_observer_cfg_t &c = to.built.observer;
    const int weight = 12 + static_cast<int>(c.weight_shift);
    const double base_x = std::ldexp(to.bases.current_a, static_cast<int>(c.current_shift));
    to.add("observer.decay", c.decay, "T·R/L_d = {:.5g}",
           scaled(c.decay, weight) * std::ldexp(1.0, static_cast<int>(c.current_shift)));
    to.add("observer.volt_gain", c.volt_gain, "T/L_d = {:.5g} A/V",
           scaled(c.volt_gain, weight) * base_x / to.bases.voltage_v);
    to.add("observer.weight_shift", c.weight_shift,
           "the two above are times 2^{}; decay is of I_b, not of I_x", weight);
    to.add("observer.flux_q27", c.flux_q27, "φ/L_d = {:.5g} A", scaled(c.flux_q27, 27) * base_x);
    to.add("observer.iq_gain_q14", c.iq_gain_q14, "L_d/L_q = {:.5g}", scaled(c.iq_gain_q14, 14));
    to.add("observer.saliency_q13", c.saliency_q13, "L_q/L_d = {:.5g}", scaled(c.saliency_q13, 13));
    to.add("observer.current_shift", c.current_shift, "I_x = {:g} A", base_x);
}

void add_adaptation(Rows &to)
{
    const nn_observer_cfg_t &c = to.built.observer;
    to.add("observer.descent_shift", c.descent_shift, "of the descent b");
    to.add("observer.rate", c.rate, "κ = {:g}", to.tuning.observer_kappa);
    to.add("observer.rate_shift", c.rate_shift, "of the rate");
    to.add("observer.proportional", c.proportional, "κ_p = {:g}", to.tuning.observer_kappa_p);
    to.add("observer.proportional_shift", c.proportional_shift, "of the proportional path");
    to.add("observer.momentum_q15", c.momentum_q15, "α = {:.5g}", scaled(c.momentum_q15, 15));
    to.add("observer.speed_limit", c.speed_limit, "{:.6g} rpm", to.rpm(c.speed_limit));
    to.add("observer.corner", c.corner, "R/L_d = {:.5g} rad/s electrical",
           scaled(c.corner, 32) * TWO_PI / to.bases.control_period_s);
    to.add("observer.rho_max_q13", c.rho_max_q13, "largest ρ {:.5g}", scaled(c.rho_max_q13, 13));
    to.add("observer.rho_speed_min", c.rho_speed_min, "ρ = 0 below {:.5g} rpm",
           to.rpm(c.rho_speed_min));
}

// `source` says what the gains follow from.
void add_pi(Rows &to, const std::string &name, const pi_cfg_t &c, const std::string &source = "")
{
    to.add(name + ".kp", c.kp, "K_p = {:.5g} per unit{}",
           scaled(c.kp, static_cast<int>(c.kp_shift)), source);
    to.add(name + ".ki", c.ki, "K_i·T = {:.5g} per unit",
           scaled(c.ki, static_cast<int>(c.ki_shift) + PI_INTEGRAL_BITS));
    to.add(name + ".kp_shift", c.kp_shift, "of K_p");
    to.add(name + ".ki_shift", c.ki_shift, "of K_i·T, less {}", PI_INTEGRAL_BITS);
}

void add_current_loop(Rows &to, const std::string &name, const current_loop_cfg_t &c)
{
    const double impedance = to.bases.voltage_v / to.bases.current_a;
    const double inductance = impedance / to.bases.speed_el_rad_s;
    add_pi(to, name + ".pi_d", c.pi_d);
    add_pi(to, name + ".pi_q", c.pi_q);
    to.add(name + ".reactance_d_q13", c.reactance_d_q13, "L_d = {:.5g} H",
           scaled(c.reactance_d_q13, 13) * inductance);
    to.add(name + ".reactance_q_q13", c.reactance_q_q13, "L_q = {:.5g} H",
           scaled(c.reactance_q_q13, 13) * inductance);
    to.add(name + ".emf_q13", c.emf_q13, "φ = {:.5g} Wb",
           scaled(c.emf_q13, 13) * to.bases.voltage_v / to.bases.speed_el_rad_s);
    to.add(name + ".resistance_q13", c.resistance_q13, "R = {:.5g} Ω",
           scaled(c.resistance_q13, 13) * impedance);
}

void add_speed_loop(Rows &to)
{
    const speed_loop_cfg_t &c = to.built.speed_loop;
    add_pi(to, "speed_loop.pi", c.pi,
           fmt::format(", for a bandwidth of {:.5g} Hz", to.tuning.speed_bandwidth_hz));
    to.add("speed_loop.ramp", c.ramp, "{:.6g} rpm/s",
           to.bases.rpm_from_step(c.ramp) / to.slow_period());
    to.add("speed_loop.speed_max", c.speed_max, "{:.6g} rpm", to.bases.rpm_from_step(c.speed_max));
    to.add("speed_loop.inertia", c.inertia, "{:g} of J = {:g} kg·m²",
           to.config.tuning.inertia_feed_forward,
           to.config.motor.inertia_kg_m2 * to.config.model.inertia);
    to.add("speed_loop.inertia_shift", c.inertia_shift, "of the inertia");
    to.add("speed_loop.inertia_lift", c.inertia_lift, "of the change before it");
    to.add("speed_loop.error_shift", c.error_shift, "steps to the Q15 speed error");
}

void add_position_loop(Rows &to)
{
    const position_loop_cfg_t &c = to.built.position_loop;
    const double unit = std::exp2(static_cast<double>(c.distance_shift) - 32);
    to.add("position_loop.ramp", c.ramp, "{:.6g} rad/s² mechanical",
           to.bases.rpm_from_step(c.ramp) * TWO_PI / 60 / to.slow_period());
    to.add("position_loop.speed_max", c.speed_max, "{:.6g} rpm",
           to.bases.rpm_from_step(c.speed_max));
    to.add("position_loop.braking_inverse", c.braking_inverse,
           "brakes from full speed in {:.5g} electrical turns",
           std::exp2(30) / c.braking_inverse * unit);
    to.add("position_loop.softness_q15", c.softness_q15, "settles with {:.5g} s",
           to.tuning.position_softness_s);
    to.add("position_loop.gain", c.gain, "bandwidth {:.5g} Hz", to.tuning.position_bandwidth_hz);
    to.add("position_loop.gain_shift", c.gain_shift, "of the gain");
    to.add("position_loop.distance_shift", c.distance_shift,
           "distance unit {:.4g} electrical turns", unit);
}

void add_modulator(Rows &to)
{
    const modulator_cfg_t &c = to.built.modulator;
    to.add("modulator.timer_counts", c.timer_counts, "{:g} Hz, centre-aligned, from {:g} Hz",
           to.config.board.pwm_frequency_hz, to.config.board.timer_clock_hz);
    to.add("modulator.ratio_max_q15", c.ratio_max_q15, "{:.5g} of the bus voltage",
           scaled(c.ratio_max_q15, 15));
    to.add("modulator.inverse_max_q12", c.inverse_max_q12, "down to {:.5g} V",
           to.bases.voltage_v / scaled(c.inverse_max_q12, 12));
    to.add("modulator.dead_time_q15", c.dead_time_q15, "{:.4g} s given back",
           scaled(c.dead_time_q15, 15) * to.bases.control_period_s);
    to.add("modulator.drop_q15", c.drop_q15, "{:.4g} V given back", to.volt(c.drop_q15));
    to.add("modulator.ripple_q15", c.ripple_q15, "u·T/(12·L) = {:.4g} A", to.ampere(c.ripple_q15));
    to.add("modulator.edge_slope", c.edge_slope, "all is given back {:.4g} A above the ripple",
           to.bases.current_a / c.edge_slope);
}

void add_catch_spin(Rows &to)
{
    const catch_spin_cfg_t &c = to.built.startup.catch_spin;
    to.add("startup.catch_spin.current", c.current, "a pulse ends above {:.5g} A",
           to.ampere(c.current));
    to.add("startup.catch_spin.wait_ticks", c.wait_ticks, "{:.4g} s, until nothing flows",
           c.wait_ticks * to.bases.control_period_s);
    to.add("startup.catch_spin.pulse_ticks", c.pulse_ticks, "or after {:.4g} s",
           to.seconds(c.pulse_ticks));
    to.add("startup.catch_spin.gap_factor", c.gap_factor, "the pause, in pulses");
    to.add("startup.catch_spin.pause_max", c.pause_max, "ticks, at most");
    to.add("startup.catch_spin.emf_current", c.emf_current, "{:.5g} A a tick at {:g} rpm",
           std::ldexp(c.emf_current, -16 - static_cast<int>(c.emf_shift)) *
               to.bases.step_from_rpm(to.config.motor.rated_speed_rpm) / std::exp2(15) *
               to.bases.current_a,
           to.config.motor.rated_speed_rpm);
    to.add("startup.catch_spin.emf_shift", c.emf_shift, "of the current for a speed");
    to.add("startup.catch_spin.charge_ticks", c.charge_ticks,
           "low sides on for {:.4g} s at a standing rotor", to.seconds(c.charge_ticks));
}

void add_align(Rows &to)
{
    const align_cfg_t &c = to.built.startup.align;
    to.add("startup.align.current_high", c.current_high, "{:.5g} A", to.ampere(c.current_high));
    to.add("startup.align.current_low", c.current_low, "{:.5g} A", to.ampere(c.current_low));
    to.add("startup.align.slope", c.slope, "{:.5g} A/s",
           to.ampere(c.slope) / to.bases.control_period_s);
    to.add("startup.align.sweep_speed", c.sweep_speed, "the vector turns with {:.5g} rpm",
           to.rpm(c.sweep_speed));
    to.add("startup.align.sweep_ticks", c.sweep_ticks, "for {:.4g} s", to.seconds(c.sweep_ticks));
    to.add("startup.align.pull_ticks", c.pull_ticks, "and comes to rest until {:.4g} s",
           to.seconds(c.pull_ticks));
    to.add("startup.align.settle_ticks", c.settle_ticks, "{:.4g} s between the measurements",
           to.seconds(c.settle_ticks));
    to.add("startup.align.measure_log2", c.measure_log2, "means over {:.4g} s",
           std::exp2(c.measure_log2) * to.bases.control_period_s);
    to.add("startup.align.step_ticks", c.step_ticks, "{:.4g} s", to.seconds(c.step_ticks));
    to.add("startup.align.step_voltage", c.step_voltage, "{:.5g} V lower for so long",
           to.volt(c.step_voltage));
    to.add("startup.align.step_fall", c.step_fall, "lowers the current by {:.5g} A",
           to.ampere(c.step_fall));
    to.add("startup.align.step_drop_q14", c.step_drop_q14, "R·t/(2·L_d) = {:.4g}",
           scaled(c.step_drop_q14, 14));
}

void add_startup(Rows &to)
{
    const startup_cfg_t &c = to.built.startup;
    add_catch_spin(to);
    add_align(to);
    to.add("startup.current_hold", c.current_hold, "{:.5g} A imposed at standstill",
           to.ampere(c.current_hold));
    to.add("startup.current_move", c.current_move, "{:.5g} A imposed in motion",
           to.ampere(c.current_move));
    to.add("startup.current_slope", c.current_slope, "{:.5g} A/s",
           to.ampere(c.current_slope) / to.bases.control_period_s);
    to.add("startup.ramp", c.ramp, "the vector's ramp {:.6g} rpm/s",
           to.rpm(c.ramp) / to.slow_period());
    to.add("startup.track_speed", c.track_speed, "the observer runs free above {:.5g} rpm",
           to.rpm(c.track_speed));
    to.add("startup.handover_speed", c.handover_speed, "takes over above {:.5g} rpm",
           to.rpm(c.handover_speed));
    to.add("startup.hold_speed", c.hold_speed, "hands back below {:.5g} rpm", to.rpm(c.hold_speed));
    to.add("startup.residual_max", c.residual_max, "takes over with a residual below {:.5g} A",
           to.ampere(c.residual_max));
    to.add("startup.residual_lost", c.residual_lost, "starts again with one above {:.5g} A",
           to.ampere(c.residual_lost));
    to.add("startup.lost_periods", c.lost_periods, "for {:.4g} s",
           c.lost_periods * to.slow_period());
    to.add("startup.handover_periods", c.handover_periods, "within {:.4g} s",
           c.handover_periods * to.slow_period());
    to.add("startup.attempts", c.attempts, "starts before it is a fault");
}

void add_run(Rows &to)
{
    const run_cfg_t &c = to.built.run;
    to.add("run.current_floor", c.current_floor, "at least {:.5g} A in RUN",
           to.ampere(c.current_floor));
    to.add("run.current_slope", c.current_slope, "{:.5g} A/s",
           to.ampere(c.current_slope) / to.bases.control_period_s);
}

void add_model(Rows &to)
{
    const model_cfg_t &c = to.built.model;
    to.add("model.resistance_limit_q14", c.resistance_limit_q14, "R is corrected by up to {:.4g} %",
           100 * scaled(c.resistance_limit_q14, 14));
    to.add("model.inductance_limit_q14", c.inductance_limit_q14, "L by up to {:.4g} %",
           100 * scaled(c.inductance_limit_q14, 14));
    to.add("model.flux_limit_q14", c.flux_limit_q14, "φ by up to {:.4g} %",
           100 * scaled(c.flux_limit_q14, 14));
    const double ratio_per_ampere = c.flux_rate * std::exp2(15 - 30) / to.bases.current_a;
    to.add("model.flux_rate", c.flux_rate, "{:.4g} of φ a second and ampere",
           ratio_per_ampere / to.slow_period());
    to.add("model.flux_speed_min", c.flux_speed_min, "φ is corrected above {:.5g} rpm",
           to.rpm(c.flux_speed_min));
}

void add_voltage_drive(Rows &to)
{
    const voltage_drive_cfg_t &c = to.built.voltage_drive;
    const double degree = 360 / STEPS_PER_TURN;
    const double volt_per_rad_s = to.bases.voltage_v / (2 * to.bases.speed_el_rad_s);
    to.add("voltage_drive.enabled", c.enabled, "1: RUN without current regulators");
    to.add("voltage_drive.pi.kp", c.pi.kp, "{:.5g} V·s/rad",
           scaled(c.pi.kp, static_cast<int>(c.pi.kp_shift)) * volt_per_rad_s);
    to.add("voltage_drive.pi.ki", c.pi.ki, "{:.5g} V/rad",
           scaled(c.pi.ki, static_cast<int>(c.pi.ki_shift) + PI_INTEGRAL_BITS) * volt_per_rad_s /
               to.slow_period());
    to.add("voltage_drive.pi.kp_shift", c.pi.kp_shift, "of kp");
    to.add("voltage_drive.pi.ki_shift", c.pi.ki_shift, "of ki, less {}", PI_INTEGRAL_BITS);
    to.add("voltage_drive.speed_min", c.speed_min, "{:.5g} rpm, current control below",
           to.rpm(c.speed_min));
    to.add("voltage_drive.settle_periods", c.settle_periods, "calm for {:.4g} s before",
           c.settle_periods * to.slow_period());
    to.add("voltage_drive.compensator.gain", c.compensator.gain, "g = {:.4g} a sample",
           scaled(c.compensator.gain, 16 + static_cast<int>(c.compensator.gain_shift)));
    to.add("voltage_drive.compensator.gain_shift", c.compensator.gain_shift, "of g");
    to.add("voltage_drive.compensator.lead_max", c.compensator.lead_max, "leads by at most {:.4g}°",
           c.compensator.lead_max * degree);
    to.add("voltage_drive.compensator.brake_max", c.compensator.brake_max,
           "lags by at most {:.4g}°", c.compensator.brake_max * degree);
    to.add("voltage_drive.compensator.current_min", c.compensator.current_min,
           "i_q counts as at least {:.4g} A", to.ampere(c.compensator.current_min));
}

} // namespace

std::vector<ConfigRow> describe(const Config &config, const drive_cfg_t &built)
{
    Rows to = {config,
               settled_tuning(config.motor, config.board, config.tuning, config.model),
               built,
               make_bases(config.motor, config.board),
               {}};
    add_sampling(to);
    add_protection(to);
    add_derating(to);
    add_network(to);
    add_adaptation(to);
    add_current_loop(to, "current_loop", built.current_loop);
    add_speed_loop(to);
    add_position_loop(to);
    add_modulator(to);
    add_supervision(to);
    add_current_loop(to, "hold_loop", built.hold_loop);
    add_startup(to);
    add_run(to);
    add_model(to);
    add_voltage_drive(to);
    to.add("speed_shift", built.speed_shift, "steps to Q15 of Ω_b = {:.6g} rad/s electrical",
           to.bases.speed_el_rad_s);
    to.add("slow_ticks", built.slow_ticks, "slow period {:g} s", to.slow_period());
    to.add("crc", built.crc, "of all above, CRC-32");
    return to.rows;
}

} // namespace nf
