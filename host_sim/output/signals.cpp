// SPDX-License-Identifier: MIT
#include "signals.h"

#include "names.h"
#include "suggest.h"

extern "C" {
#include "fault_text.h"
}

#include <cmath>
#include <cstring>
#include <type_traits>
#include <unordered_map>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double Q12 = 4096.0;
constexpr double Q13 = 8192.0;
constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q16 = 65536.0;
constexpr double Q24 = 16777216.0;
constexpr double Q26 = 67108864.0;
constexpr double Q27 = 134217728.0;
constexpr double Q30 = 1073741824.0;
constexpr double Q32 = 4294967296.0;
constexpr double PI = 3.14159265358979323846;
constexpr double RPM_PER_RAD_S = 30.0 / PI;
constexpr double DEG_PER_RAD = 180.0 / PI;
constexpr double DEG_PER_STEP = 360.0 / Q32;

double speed_command(const Tick &t)
{
    return t.mode == DriveMode::speed
               ? t.command
               : t.sim->bases().rpm_from_step(t.sim->drive().speed_reference);
}

double position_estimated(const Tick &t)
{
    const double turns = static_cast<double>(t.position_estimate_q32) / Q32;
    return turns * 2.0 * PI / t.sim->bases().pole_pairs;
}

double angle_estimated(const Tick &t)
{
    const auto angle = static_cast<uint32_t>(static_cast<uint64_t>(t.position_estimate_q32));
    return static_cast<int32_t>(angle) * DEG_PER_STEP;
}

// ΔW2/T, (22): by how much this tick has lowered the observer's speed.
double weight_change(const Tick &t)
{
    return t.sim->bases().rpm_from_step(static_cast<double>(t.observer_speed) -
                                        t.sim->drive().observer.speed);
}

// β, by which the voltage is ahead of the q axis, in its own direction; 0 with current regulators.
double lead(const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    const dq_t &v = drive.signals.voltage;
    const double along = drive.voltage_magnitude < 0 ? -1 : 1;
    return drive.voltage_driven ? std::atan2(-v.d * along, v.q * along) * DEG_PER_RAD : 0.0;
}

double duty(const Tick &t, std::size_t leg)
{
    const double full = t.sim->cfg().modulator.timer_counts;
    return t.sim->out().compare.phase[leg] / full;
}

SignalInfo derived(const char *name, Quantity quantity, double (*value)(const Tick &))
{
    return {name, quantity, value, {}};
}

template <typename T>
SignalInfo word(const char *name, Quantity quantity, Word::Home home, std::size_t offset,
                const char *member)
{
    using Plain = typename std::conditional_t<std::is_enum_v<T>, std::underlying_type<T>,
                                              std::common_type<T>>::type;
    return {name, quantity, nullptr, {home, offset, sizeof(T), std::is_signed_v<Plain>, member}};
}

// A member's name, place and type are one thing: only the preprocessor can tell all three from one mention.
#define FIELD(name, home, type, member, quantity) \
    word<std::remove_reference_t<decltype(std::declval<type &>().member)>>( \
        name, Quantity::quantity, Word::Home::home, offsetof(type, member), #member)
#define IN(member, quantity) FIELD("in." #member, in, drive_in_t, member, quantity)
#define OUT(member, quantity) FIELD("out." #member, out, drive_out_t, member, quantity)
#define DRIVE(member, quantity) FIELD("drive." #member, drive, drive_t, member, quantity)
#define ALIAS(name, member, quantity) FIELD(name, drive, drive_t, member, quantity)
#define CFG(member, quantity) FIELD("cfg." #member, cfg, drive_cfg_t, member, quantity)

std::vector<SignalInfo> run_signals()
{
    using Q = Quantity;
    return {
        derived("time_s", Q::time_s, [](const Tick &t) { return t.time_s; }),
        ALIAS("state", state, state),
        ALIAS("fault", fault.id, fault),
        derived("speed_command_rpm", Q::speed_rpm, speed_command),
        derived("speed_rpm", Q::speed_rpm,
                [](const Tick &t) { return t.truth.omega_mech_rad_s * RPM_PER_RAD_S; }),
        derived("speed_estimated_rpm", Q::speed_rpm,
                [](const Tick &t) { return t.sim->bases().rpm_from_step(t.speed_estimate); }),
        ALIAS("speed_reference_rpm", speed_loop.reference, speed_step),
        derived("position_command_rad", Q::angle_rad,
                [](const Tick &t) { return t.mode == DriveMode::position ? t.command : 0.0; }),
        derived("position_rad", Q::angle_rad, [](const Tick &t) { return t.truth.theta_mech_rad; }),
        derived("position_estimated_rad", Q::angle_rad, position_estimated),
        derived("angle_el_deg", Q::angle_deg,
                [](const Tick &t) { return t.truth.theta_el_rad * DEG_PER_RAD; }),
        derived("angle_estimated_el_deg", Q::angle_deg, angle_estimated),
        derived("angle_error_el_deg", Q::angle_deg, angle_error_deg),
        derived("i_q_a", Q::current_a, [](const Tick &t) { return t.truth.i_q_a; }),
        ALIAS("i_q_estimated_a", observer.current.q, current_q15),
        ALIAS("i_q_reference_a", signals.current_ref.q, current_q15),
        derived("i_d_a", Q::current_a, [](const Tick &t) { return t.truth.i_d_a; }),
        ALIAS("i_d_estimated_a", observer.current.d, current_q15),
        derived("i_a_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[0]; }),
        derived("i_b_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[1]; }),
        derived("i_c_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[2]; }),
        ALIAS("v_d_v", signals.voltage.d, voltage_q15),
        ALIAS("v_q_v", signals.voltage.q, voltage_q15),
        derived("duty_a", Q::share, [](const Tick &t) { return duty(t, 0); }),
        derived("duty_b", Q::share, [](const Tick &t) { return duty(t, 1); }),
        derived("duty_c", Q::share, [](const Tick &t) { return duty(t, 2); }),
        derived("bus_v", Q::voltage_v, [](const Tick &t) { return t.truth.bus_v; }),
        derived("load_torque_nm", Q::torque_nm, [](const Tick &t) { return t.load_nm; }),
        derived("torque_nm", Q::torque_nm, [](const Tick &t) { return t.truth.torque_nm; }),
    };
}

// The frames, and what the drive makes of the one in the order in which it does.
std::vector<SignalInfo> tick_signals()
{
    return {
        IN(adc_ia, adc_current),
        IN(adc_ib, adc_current),
        IN(adc_bus, adc_bus),
        IN(adc_temperature, adc_plain),
        IN(flags, number),
        IN(command.target, number),
        IN(command.mode, number),
        IN(command.request, number),
        IN(angle, shaft_q16),
        DRIVE(signals.phase_a, current_q15),
        DRIVE(signals.phase_b, current_q15),
        DRIVE(signals.bus, voltage_q15),
        DRIVE(signals.current_ab.alpha, current_q15),
        DRIVE(signals.current_ab.beta, current_q15),
        DRIVE(signals.current.d, current_q15),
        DRIVE(signals.current.q, current_q15),
        DRIVE(signals.current_frame.d, current_q15),
        DRIVE(signals.current_frame.q, current_q15),
        DRIVE(signals.current_mean.d, current_q15),
        DRIVE(signals.current_mean.q, current_q15),
        DRIVE(signals.voltage_applied.alpha, voltage_q15),
        DRIVE(signals.voltage_applied.beta, voltage_q15),
        DRIVE(observer.alpha_q27, network_q27),
        DRIVE(observer.beta_q27, network_q27),
        DRIVE(observer.state.d, network_q15),
        DRIVE(observer.state.q, network_q15),
        DRIVE(observer.current.d, current_q15),
        DRIVE(observer.current.q, current_q15),
        DRIVE(observer.error.d, current_q15),
        DRIVE(observer.error.q, current_q15),
        DRIVE(observer.rho_q13, ratio_q13),
        DRIVE(observer.turned.d, current_q15),
        DRIVE(observer.turned.q, current_q15),
        DRIVE(observer.descent, descent),
        DRIVE(observer.weight_step, speed_step),
        derived("weight_change_rpm", Quantity::speed_rpm, weight_change),
        DRIVE(observer.speed, speed_step),
        DRIVE(observer.speed_out, speed_step),
        DRIVE(signals.speed, speed_q15),
        DRIVE(signals.current_ref.d, current_q15),
        DRIVE(signals.current_ref.q, current_q15),
        DRIVE(signals.voltage_limit, voltage_q15),
        DRIVE(signals.voltage.d, voltage_q15),
        DRIVE(signals.voltage.q, voltage_q15),
        DRIVE(voltage_driven, flag),
        DRIVE(voltage_periods, number),
        DRIVE(voltage_magnitude, voltage_q15),
        derived("lead_el_deg", Quantity::angle_deg, lead),
        DRIVE(compensator.current_angle, turns_q32),
        DRIVE(compensator.angle, turns_q32),
        DRIVE(signals.ratio_ab.alpha, ratio_q15),
        DRIVE(signals.ratio_ab.beta, ratio_q15),
        OUT(compare.phase[0], compare),
        OUT(compare.phase[1], compare),
        OUT(compare.phase[2], compare),
        OUT(gate_enable, flag),
    };
}

// What the drive keeps from tick to tick beside it.
std::vector<SignalInfo> state_signals()
{
    return {
        DRIVE(position.turns_q32, turns_q32),
        DRIVE(frame.turns_q32, turns_q32),
        DRIVE(frame_speed, speed_step),
        DRIVE(state, state),
        DRIVE(tick, number),
        DRIVE(slow_count, number),
        DRIVE(mode, number),
        DRIVE(offset_samples, number),
        DRIVE(offset_a, current_q15),
        DRIVE(offset_b, current_q15),
        DRIVE(bus_before, voltage_q15),
        DRIVE(ratio_acting.alpha, ratio_q15),
        DRIVE(ratio_acting.beta, ratio_q15),
        DRIVE(modulator.inverse_bus_q12, inverse_q12),
        DRIVE(current_loop.pi_d.integral_q26, voltage_q26),
        DRIVE(current_loop.pi_q.integral_q26, voltage_q26),
        DRIVE(speed_reference, speed_step),
        DRIVE(speed_loop.reference, speed_step),
        DRIVE(speed_loop.pi.integral_q26, current_q26),
        DRIVE(position_loop.profile_q32, turns_q32),
        DRIVE(position_loop.profile_speed, speed_step),
        DRIVE(torque_range.lower, current_q15),
        DRIVE(torque_range.upper, current_q15),
        DRIVE(residual, current_q15),
        DRIVE(lost_periods, number),
        DRIVE(handover_periods, number),
        DRIVE(attempts, number),
        DRIVE(identified, flag),
        DRIVE(derating.heat_q24, ratio_q24),
        DRIVE(derating.motoring, current_q15),
        DRIVE(derating.braking, current_q15),
        DRIVE(limits.current_max, current_q15),
        DRIVE(limits.bus_max, voltage_q15),
        DRIVE(limits.bus_min, voltage_q15),
        DRIVE(fault.id, fault),
        DRIVE(fault.value, number),
        DRIVE(fault.limit, number),
        DRIVE(fault.tick, number),
    };
}

// What finds the rotor.
std::vector<SignalInfo> start_signals()
{
    return {
        DRIVE(catch_spin.tick, number),
        DRIVE(catch_spin.phase, number),
        DRIVE(catch_spin.length, number),
        DRIVE(catch_spin.first.alpha, current_q15),
        DRIVE(catch_spin.first.beta, current_q15),
        DRIVE(catch_spin.gates, flag),
        DRIVE(catch_spin.speed, speed_step),
        DRIVE(catch_spin.angle, turns_q32),
        DRIVE(align.phase, number),
        DRIVE(align.tick, number),
        DRIVE(align.backwards, flag),
        DRIVE(align.current_ref, current_q15),
        DRIVE(align.frame_speed, speed_step),
        DRIVE(align.step_start, current_q15),
        DRIVE(align.step_fall, current_q15),
        DRIVE(align.high.voltage, voltage_q15),
        DRIVE(align.high.current, current_q15),
        DRIVE(align.low.voltage, voltage_q15),
        DRIVE(align.low.current, current_q15),
    };
}

// What limits and watches.
std::vector<SignalInfo> watch_signals()
{
    return {
        DRIVE(derating.thermal, current_q15),
        DRIVE(derating.too_hot, number),
        DRIVE(derating.voltage.d, voltage_q15),
        DRIVE(derating.voltage.q, voltage_q15),
        DRIVE(derating.flags_slow, number),
        DRIVE(derating.flags, number),
        DRIVE(supervision.step, number),
        DRIVE(supervision.late, number),
        DRIVE(supervision.late_periods, number),
        DRIVE(supervision.start_q16, turns_q16),
        DRIVE(supervision.samples, number),
        DRIVE(supervision.lowest[0], current_q15),
        DRIVE(supervision.lowest[1], current_q15),
        DRIVE(supervision.lowest[2], current_q15),
        DRIVE(supervision.highest[0], current_q15),
        DRIVE(supervision.highest[1], current_q15),
        DRIVE(supervision.highest[2], current_q15),
        DRIVE(supervision.weak, number),
        DRIVE(supervision.weak_arcs, number),
        DRIVE(supervision.suspect.id, fault),
        DRIVE(supervision.suspect.value, number),
        DRIVE(supervision.suspect.limit, number),
        DRIVE(supervision.suspect.tick, number),
        DRIVE(supervision.absent, number),
        DRIVE(supervision.absent_periods, number),
        DRIVE(supervision.unexplained, number),
        DRIVE(supervision.off_current.d, number),
        DRIVE(supervision.off_current.q, number),
        DRIVE(supervision.off_reference, number),
        DRIVE(supervision.runaway, number),
        DRIVE(supervision.too_fast, number),
        DRIVE(supervision.stalled, number),
        DRIVE(supervision.residual, number),
        DRIVE(guard.at, number),
        DRIVE(guard.crc, number),
    };
}

std::vector<SignalInfo> model_signals()
{
    return {
        DRIVE(model.resistance_q14, ratio_q14),
        DRIVE(model.inductance_q14, ratio_q14),
        DRIVE(model.inductance_inverse_q14, ratio_q14),
        DRIVE(model.flux_q30, ratio_q30),
        DRIVE(model.observer.decay, number),
        DRIVE(model.observer.volt_gain, number),
        DRIVE(model.observer.flux_q27, network_q27),
        DRIVE(model.observer.rate, number),
        DRIVE(model.observer.proportional, number),
        DRIVE(model.observer.corner, speed_step),
        DRIVE(model.run_loop.resistance_q13, ratio_q13),
        DRIVE(model.run_loop.emf_q13, ratio_q13),
        DRIVE(model.run_loop.pi_d.kp, number),
        DRIVE(model.run_loop.pi_d.ki, number),
        DRIVE(model.run_loop.pi_q.kp, number),
        DRIVE(model.run_loop.pi_q.ki, number),
        DRIVE(model.hold_loop.resistance_q13, ratio_q13),
        DRIVE(model.hold_loop.emf_q13, ratio_q13),
        DRIVE(model.observer.weight_shift, number),
        DRIVE(model.observer.iq_gain_q14, ratio_q14),
        DRIVE(model.observer.saliency_q13, ratio_q13),
        DRIVE(model.observer.current_shift, number),
        DRIVE(model.observer.descent_shift, number),
        DRIVE(model.observer.rate_shift, number),
        DRIVE(model.observer.proportional_shift, number),
        DRIVE(model.observer.momentum_q15, ratio_q15),
        DRIVE(model.observer.speed_limit, speed_step),
        DRIVE(model.observer.rho_max_q13, ratio_q13),
        DRIVE(model.observer.rho_speed_min, speed_step),
        DRIVE(model.run_loop.pi_d.kp_shift, number),
        DRIVE(model.run_loop.pi_d.ki_shift, number),
        DRIVE(model.run_loop.pi_q.kp_shift, number),
        DRIVE(model.run_loop.pi_q.ki_shift, number),
        DRIVE(model.run_loop.reactance_d_q13, ratio_q13),
        DRIVE(model.run_loop.reactance_q_q13, ratio_q13),
        DRIVE(model.hold_loop.pi_d.kp, number),
        DRIVE(model.hold_loop.pi_d.ki, number),
        DRIVE(model.hold_loop.pi_d.kp_shift, number),
        DRIVE(model.hold_loop.pi_d.ki_shift, number),
        DRIVE(model.hold_loop.pi_q.kp, number),
        DRIVE(model.hold_loop.pi_q.ki, number),
        DRIVE(model.hold_loop.pi_q.kp_shift, number),
        DRIVE(model.hold_loop.pi_q.ki_shift, number),
        DRIVE(model.hold_loop.reactance_d_q13, ratio_q13),
        DRIVE(model.hold_loop.reactance_q_q13, ratio_q13),
    };
}

// Of what runs in every tick.
std::vector<SignalInfo> control_configuration()
{
    return {
        CFG(observer.decay, number),
        CFG(observer.volt_gain, number),
        CFG(observer.weight_shift, number),
        CFG(observer.flux_q27, network_q27),
        CFG(observer.iq_gain_q14, ratio_q14),
        CFG(observer.saliency_q13, ratio_q13),
        CFG(observer.current_shift, number),
        CFG(observer.descent_shift, number),
        CFG(observer.rate, number),
        CFG(observer.rate_shift, number),
        CFG(observer.proportional, number),
        CFG(observer.proportional_shift, number),
        CFG(observer.momentum_q15, ratio_q15),
        CFG(observer.speed_limit, speed_step),
        CFG(observer.corner, speed_step),
        CFG(observer.rho_max_q13, ratio_q13),
        CFG(observer.rho_speed_min, speed_step),
        CFG(current_loop.pi_d.kp, number),
        CFG(current_loop.pi_d.ki, number),
        CFG(current_loop.pi_d.kp_shift, number),
        CFG(current_loop.pi_d.ki_shift, number),
        CFG(current_loop.pi_q.kp, number),
        CFG(current_loop.pi_q.ki, number),
        CFG(current_loop.pi_q.kp_shift, number),
        CFG(current_loop.pi_q.ki_shift, number),
        CFG(current_loop.reactance_d_q13, ratio_q13),
        CFG(current_loop.reactance_q_q13, ratio_q13),
        CFG(current_loop.emf_q13, ratio_q13),
        CFG(current_loop.resistance_q13, ratio_q13),
        CFG(modulator.inverse_max_q12, inverse_q12),
        CFG(modulator.edge_slope, number),
        CFG(protection.current_max, current_q15),
        CFG(protection.bus_max, voltage_q15),
        CFG(protection.bus_min, voltage_q15),
        CFG(protection.offset_max, current_q15),
        CFG(hold_loop.pi_d.kp, number),
        CFG(hold_loop.pi_d.ki, number),
        CFG(hold_loop.pi_d.kp_shift, number),
        CFG(hold_loop.pi_d.ki_shift, number),
        CFG(hold_loop.pi_q.kp, number),
        CFG(hold_loop.pi_q.ki, number),
        CFG(hold_loop.pi_q.kp_shift, number),
        CFG(hold_loop.pi_q.ki_shift, number),
        CFG(hold_loop.reactance_d_q13, ratio_q13),
        CFG(hold_loop.reactance_q_q13, ratio_q13),
        CFG(hold_loop.emf_q13, ratio_q13),
        CFG(hold_loop.resistance_q13, ratio_q13),
    };
}

// Of the slow period.
std::vector<SignalInfo> motion_configuration()
{
    return {
        CFG(derating.heat_shift, number),
        CFG(derating.heat_gain, number),
        CFG(derating.heat_rate, number),
        CFG(derating.heat_rate_shift, number),
        CFG(derating.heat_max_q14, ratio_q14),
        CFG(derating.heat.zero, ratio_q14),
        CFG(derating.heat.gain, number),
        CFG(derating.heat.shift, number),
        CFG(derating.temperature.zero, number),
        CFG(derating.temperature.gain, number),
        CFG(derating.temperature.shift, number),
        CFG(derating.temperature_periods, number),
        CFG(derating.bus_high.zero, voltage_q15),
        CFG(derating.bus_high.gain, number),
        CFG(derating.bus_high.shift, number),
        CFG(derating.bus_low.zero, voltage_q15),
        CFG(derating.bus_low.gain, number),
        CFG(derating.bus_low.shift, number),
        CFG(derating.regeneration_speed, speed_step),
        CFG(derating.bus_current_max, number),
        CFG(derating.bus_regeneration_max, number),
        CFG(speed_loop.pi.kp_shift, number),
        CFG(speed_loop.pi.ki_shift, number),
        CFG(speed_loop.inertia_shift, number),
        CFG(speed_loop.inertia_lift, number),
        CFG(speed_loop.error_shift, number),
        CFG(position_loop.braking_inverse, number),
        CFG(position_loop.softness_q15, ratio_q15),
        CFG(position_loop.gain_shift, number),
        CFG(position_loop.distance_shift, number),
        CFG(voltage_drive.pi.kp_shift, number),
        CFG(voltage_drive.pi.ki_shift, number),
        CFG(voltage_drive.settle_periods, number),
        CFG(voltage_drive.compensator.gain_shift, number),
    };
}

// Of start-up.
std::vector<SignalInfo> start_configuration()
{
    return {
        CFG(startup.catch_spin.current, current_q15),
        CFG(startup.catch_spin.wait_ticks, number),
        CFG(startup.catch_spin.pulse_ticks, number),
        CFG(startup.catch_spin.gap_factor, number),
        CFG(startup.catch_spin.pause_max, number),
        CFG(startup.catch_spin.emf_current, number),
        CFG(startup.catch_spin.charge_ticks, number),
        CFG(startup.catch_spin.emf_shift, number),
        CFG(startup.align.current_high, current_q15),
        CFG(startup.align.current_low, current_q15),
        CFG(startup.align.slope, current_q15),
        CFG(startup.align.sweep_speed, speed_step),
        CFG(startup.align.sweep_ticks, number),
        CFG(startup.align.pull_ticks, number),
        CFG(startup.align.settle_ticks, number),
        CFG(startup.align.measure_log2, number),
        CFG(startup.align.step_ticks, number),
        CFG(startup.align.step_voltage, voltage_q15),
        CFG(startup.align.step_fall, current_q15),
        CFG(startup.align.step_drop_q14, ratio_q14),
        CFG(startup.current_move, current_q15),
        CFG(startup.current_slope, current_q15),
        CFG(startup.ramp, speed_step),
        CFG(startup.track_speed, speed_step),
        CFG(startup.residual_max, current_q15),
        CFG(startup.residual_lost, current_q15),
        CFG(startup.lost_periods, number),
        CFG(startup.handover_periods, number),
        CFG(startup.attempts, number),
    };
}

// Of what RUN imposes, and of the model's correction.
std::vector<SignalInfo> model_configuration()
{
    return {
        CFG(run.current_floor, current_q15),        CFG(run.current_slope, current_q15),
        CFG(model.resistance_limit_q14, ratio_q14), CFG(model.inductance_limit_q14, ratio_q14),
        CFG(model.flux_limit_q14, ratio_q14),       CFG(model.flux_rate, number),
        CFG(model.flux_speed_min, speed_step),
    };
}

// Of what is watched.
std::vector<SignalInfo> supervision_configuration()
{
    return {
        CFG(supervision.phase_range_min, current_q15),
        CFG(supervision.phase_zero_max, current_q15),
        CFG(supervision.phase_speed_max, speed_step),
        CFG(supervision.swing_periods, number),
        CFG(supervision.voltage_max, voltage_q15),
        CFG(supervision.follow_error_max, current_q15),
        CFG(supervision.residual_max, current_q15),
        CFG(supervision.mean_shift, number),
        CFG(supervision.speed_error_max, speed_step),
        CFG(supervision.speed_error_periods, number),
        CFG(supervision.runaway_periods, number),
        CFG(supervision.overspeed, speed_step),
        CFG(supervision.overspeed_periods, number),
        CFG(supervision.stall_current, current_q15),
        CFG(supervision.stall_speed, speed_step),
        CFG(supervision.stall_periods, number),
        CFG(supervision.late_max, number),
        CFG(supervision.late_window, number),
    };
}

std::vector<SignalInfo> configuration_signals()
{
    return {
        CFG(speed_shift, number),
        CFG(sampling.current_shift, number),
        CFG(sampling.bus_shift, number),
        CFG(sampling.offset_log2, number),
        CFG(sampling.sensor_pole_pairs, number),
        CFG(modulator.timer_counts, number),
        CFG(modulator.ratio_max_q15, ratio_q15),
        CFG(modulator.dead_time_q15, ratio_q15),
        CFG(modulator.drop_q15, voltage_q15),
        CFG(modulator.ripple_q15, current_q15),
        CFG(slow_ticks, number),
        CFG(derating.current_max, current_q15),
        CFG(derating.current_continuous, current_q15),
        CFG(speed_loop.pi.kp, number),
        CFG(speed_loop.pi.ki, number),
        CFG(speed_loop.ramp, speed_step),
        CFG(speed_loop.speed_max, speed_step),
        CFG(speed_loop.inertia, number),
        CFG(position_loop.ramp, speed_step),
        CFG(position_loop.speed_max, speed_step),
        CFG(position_loop.gain, number),
        CFG(startup.current_hold, current_q15),
        CFG(startup.hold_speed, speed_step),
        CFG(startup.handover_speed, speed_step),
        CFG(voltage_drive.enabled, flag),
        CFG(voltage_drive.pi.kp, number),
        CFG(voltage_drive.pi.ki, number),
        CFG(voltage_drive.speed_min, speed_step),
        CFG(voltage_drive.compensator.gain, number),
        CFG(voltage_drive.compensator.lead_max, turns_q32),
        CFG(voltage_drive.compensator.brake_max, turns_q32),
        CFG(voltage_drive.compensator.current_min, current_q15),
        CFG(crc, number),
    };
}

#undef FIELD
#undef IN
#undef OUT
#undef DRIVE
#undef ALIAS
#undef CFG

// SI = (raw − zero) · one.
struct Format {
    const char *unit;
    const char *text; // with {} for the base
    double base;
    double one;
    double zero = 0;
};

Format simple_format(Quantity quantity)
{
    switch (quantity) {
    case Quantity::time_s:
        return {"s", "", 1, 1};
    case Quantity::angle_rad:
        return {"rad", "", 1, 1};
    case Quantity::angle_deg:
        return {"deg", "", 1, 1};
    case Quantity::torque_nm:
        return {"N m", "", 1, 1};
    case Quantity::flag:
        return {"", "flag", 1, 1};
    case Quantity::state:
        return {"", "state", 1, 1};
    case Quantity::fault:
        return {"", "fault", 1, 1};
    case Quantity::adc_plain:
        return {"", "ADC count", 1, 1};
    case Quantity::turns_q32:
        return {"turns el", "Q32", 1, 1 / Q32};
    case Quantity::turns_q16:
        return {"turns el", "Q16", 1, 1 / Q16};
    case Quantity::shaft_q16:
        return {"turns", "Q16 of a turn of the shaft", 1, 1 / Q16};
    case Quantity::ratio_q13:
        return {"", "Q13", 1, 1 / Q13};
    case Quantity::ratio_q14:
        return {"", "Q14", 1, 1 / Q14};
    case Quantity::ratio_q15:
        return {"", "Q15", 1, 1 / Q15};
    case Quantity::ratio_q24:
        return {"", "Q24", 1, 1 / Q24};
    case Quantity::ratio_q30:
        return {"", "Q30", 1, 1 / Q30};
    case Quantity::share:
        return {"", "", 1, 1};
    default:
        return {"", "integer", 1, 1};
    }
}

Format current_format(Quantity quantity, const Simulation &sim)
{
    const double base = sim.bases().current_a;
    const double network = std::ldexp(base, static_cast<int>(sim.cfg().observer.current_shift));
    switch (quantity) {
    case Quantity::current_q15:
        return {"A", "Q15 of I_b = {:.6g} A", base, base / Q15};
    case Quantity::current_q26:
        return {"A", "Q26 of I_b = {:.6g} A", base, base / Q26};
    case Quantity::network_q15:
        return {"A", "Q15 of I_x = {:.6g} A", network, network / Q15};
    case Quantity::network_q27:
        return {"A", "Q27 of I_x = {:.6g} A", network, network / Q27};
    case Quantity::descent: {
        const int bits = 30 - static_cast<int>(sim.cfg().observer.descent_shift);
        const char *const text = bits == 18 ? "Q18 of I_b I_x = {:.6g} A2"
                                            : "Q(30 - descent_shift) of I_b I_x = {:.6g} A2";
        return {"A2", text, base * network, std::ldexp(base * network, -bits)};
    }
    case Quantity::adc_current: {
        const double counts = std::ldexp(Q15, -static_cast<int>(sim.cfg().sampling.current_shift));
        return {"A", "ADC count, one = {:.6g} A", base / counts, base / counts, counts / 2};
    }
    default:
        return {"A", "", 1, 1};
    }
}

Format voltage_format(Quantity quantity, const Simulation &sim)
{
    const double base = sim.bases().voltage_v;
    const double counts = std::ldexp(Q15, -static_cast<int>(sim.cfg().sampling.bus_shift));
    switch (quantity) {
    case Quantity::voltage_q15:
        return {"V", "Q15 of U_b = {:.6g} V", base, base / Q15};
    case Quantity::voltage_q26:
        return {"V", "Q26 of U_b = {:.6g} V", base, base / Q26};
    case Quantity::inverse_q12:
        return {"1/V", "Q12 of 1/U_b = {:.6g} 1/V", 1 / base, 1 / base / Q12};
    case Quantity::adc_bus:
        return {"V", "ADC count, one = {:.6g} V", base / counts, base / counts};
    default:
        return {"V", "", 1, 1};
    }
}

Format format_of(Quantity quantity, const Simulation &sim)
{
    switch (quantity) {
    case Quantity::current_a:
    case Quantity::current_q15:
    case Quantity::current_q26:
    case Quantity::network_q15:
    case Quantity::network_q27:
    case Quantity::descent:
    case Quantity::adc_current:
        return current_format(quantity, sim);
    case Quantity::voltage_v:
    case Quantity::voltage_q15:
    case Quantity::voltage_q26:
    case Quantity::inverse_q12:
    case Quantity::adc_bus:
        return voltage_format(quantity, sim);
    case Quantity::speed_rpm:
        return {"rpm", "", 1, 1};
    case Quantity::speed_step: {
        const double one = sim.bases().rpm_from_step(1);
        return {"rpm", "2^-32 turn el a tick = {:.6g} rpm", one, one};
    }
    case Quantity::speed_q15: {
        const double base = sim.bases().rpm_from_step(std::ldexp(Q15, sim.bases().speed_shift));
        return {"rpm", "Q15 of W_b = {:.6g} rpm", base, base / Q15};
    }
    case Quantity::compare: {
        const double full = sim.cfg().modulator.timer_counts;
        return {"", "count of {:.6g}", full, 1 / full};
    }
    default:
        return simple_format(quantity);
    }
}

template <typename Byte, typename Owner> Byte *at(Owner &owner, const Word &word)
{
    return reinterpret_cast<Byte *>(&owner) + word.offset;
}

const unsigned char *place(const Word &word, const Simulation &sim)
{
    switch (word.home) {
    case Word::Home::in:
        return at<const unsigned char>(sim.in(), word);
    case Word::Home::out:
        return at<const unsigned char>(sim.out(), word);
    case Word::Home::cfg:
        return at<const unsigned char>(sim.cfg(), word);
    case Word::Home::drive:
        break;
    }
    return at<const unsigned char>(sim.drive(), word);
}

// Little-endian two's complement, as every machine that this runs on.
int64_t read_word(const Word &word, const unsigned char *from)
{
    uint64_t bits = 0;
    std::memcpy(&bits, from, word.bytes);
    const unsigned unused = 64U - 8U * static_cast<unsigned>(word.bytes);
    const auto high = static_cast<int64_t>(bits << unused);
    return word.has_sign ? high >> unused : static_cast<int64_t>(bits);
}

} // namespace

const std::vector<SignalInfo> &all_signals()
{
    static const std::vector<SignalInfo> table = [] {
        std::vector<SignalInfo> all = run_signals();
        for (const std::vector<SignalInfo> &part :
             {tick_signals(), state_signals(), start_signals(), watch_signals(), model_signals(),
              configuration_signals(), control_configuration(), motion_configuration(),
              start_configuration(), model_configuration(), supervision_configuration()}) {
            all.insert(all.end(), part.begin(), part.end());
        }
        return all;
    }();
    return table;
}

const SignalInfo *find_signal(const std::string &name)
{
    static const std::unordered_map<std::string, const SignalInfo *> index = [] {
        std::unordered_map<std::string, const SignalInfo *> by_name;
        for (const SignalInfo &signal : all_signals()) {
            by_name.emplace(signal.name, &signal);
        }
        return by_name;
    }();
    const auto found = index.find(name);
    return found == index.end() ? nullptr : found->second;
}

std::vector<std::string> near_signals(const std::string &name, std::size_t count)
{
    std::vector<std::string> known;
    for (const SignalInfo &signal : all_signals()) {
        known.emplace_back(signal.name);
    }
    return nearest_at_all(name, known, count);
}

const char *home_text(Word::Home home)
{
    switch (home) {
    case Word::Home::in:
        return "in";
    case Word::Home::out:
        return "out";
    case Word::Home::cfg:
        return "cfg";
    case Word::Home::drive:
        break;
    }
    return "drive";
}

Scale word_scale(const SignalInfo &signal, const Simulation &sim)
{
    const Format format = format_of(signal.quantity, sim);
    return {format.unit, fmt::format(fmt::runtime(format.text), format.base), format.one,
            format.zero};
}

std::optional<int64_t> raw_value(const SignalInfo &signal, const Tick &tick)
{
    if (signal.value != nullptr) {
        return std::nullopt;
    }
    return read_word(signal.word, place(signal.word, *tick.sim));
}

std::optional<int64_t> recorded_value(const SignalInfo &signal, const Tick &tick)
{
    const bool output = signal.value == nullptr && signal.word.home == Word::Home::out;
    if (!output || tick.recorded == nullptr) {
        return std::nullopt;
    }
    return read_word(signal.word, at<const unsigned char>(*tick.recorded, signal.word));
}

double si_value(const SignalInfo &signal, const Tick &tick)
{
    if (signal.value != nullptr) {
        return signal.value(tick);
    }
    const Format scale = format_of(signal.quantity, *tick.sim);
    const int64_t raw = read_word(signal.word, place(signal.word, *tick.sim));
    return (static_cast<double>(raw) - scale.zero) * scale.one;
}

const char *unit_text(const SignalInfo &signal, const Simulation &sim)
{
    return format_of(signal.quantity, sim).unit;
}

std::string format_text(const SignalInfo &signal, const Simulation &sim)
{
    if (signal.value != nullptr) {
        return "";
    }
    return word_scale(signal, sim).format;
}

std::string word_text(const SignalInfo &signal, int64_t raw)
{
    if (signal.quantity == Quantity::state) {
        return state_name(static_cast<drive_state_t>(raw));
    }
    if (signal.quantity == Quantity::fault) {
        return fault_text(static_cast<fault_id_t>(raw))->name;
    }
    return "";
}

RawRange raw_range(const Word &word)
{
    const auto bits = static_cast<unsigned>(8 * word.bytes);
    if (!word.has_sign) {
        return {0, static_cast<int64_t>((uint64_t{1} << bits) - 1U)};
    }
    const auto highest = static_cast<int64_t>((uint64_t{1} << (bits - 1U)) - 1U);
    return {-highest - 1, highest};
}

double raw_from_si(const SignalInfo &signal, double si, const Simulation &sim)
{
    const Format scale = format_of(signal.quantity, sim);
    return std::round(si / scale.one + scale.zero);
}

void write_word(const Word &word, int64_t raw, const Seam &seam)
{
    unsigned char *const to = word.home == Word::Home::cfg ? at<unsigned char>(seam.cfg, word)
                                                           : at<unsigned char>(seam.drive, word);
    std::memcpy(to, &raw, word.bytes);
}

} // namespace nf
