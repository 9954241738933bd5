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
    return {name, quantity, value, {}, nullptr};
}

template <typename T>
SignalInfo word(const char *name, Quantity quantity, Word::Home home, std::size_t offset,
                const char *member)
{
    using Plain = typename std::conditional_t<std::is_enum_v<T>, std::underlying_type<T>,
                                              std::common_type<T>>::type;
    return {name,
            quantity,
            nullptr,
            {home, offset, sizeof(T), std::is_signed_v<Plain>, member},
            nullptr};
}

// A member's name, place and type are one thing: only the preprocessor can tell all three from one mention.
#define FIELD(name, home, type, member, quantity) \
    word<std::remove_reference_t<decltype(std::declval<type &>().member)>>( \
        name, Quantity::quantity, Word::Home::home, offsetof(type, member), #member)
#define IN(member, quantity) FIELD("in." #member, in, drive_in_t, member, quantity)
#define OUT(member, quantity) FIELD("out." #member, out, drive_out_t, member, quantity)
#define DRIVE(member, quantity) FIELD("drive." #member, drive, drive_t, member, quantity)
#define ALIAS(name, member, quantity) FIELD(name, drive, drive_t, member, quantity)

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

std::vector<SignalInfo> configuration_signals()
{
    std::vector<SignalInfo> all;
    for (const CfgRow &row : cfg_rows()) {
        all.push_back({row.signal,
                       row.quantity,
                       nullptr,
                       {Word::Home::cfg, row.offset, sizeof(uint32_t), !row.is_unsigned, row.path},
                       &row});
    }
    return all;
}

#undef FIELD
#undef IN
#undef OUT
#undef DRIVE
#undef ALIAS

Format format_of(const SignalInfo &signal, const Simulation &sim)
{
    return signal.row == nullptr ? format_of(signal.quantity, sim.bases(), sim.cfg())
                                 : format_of(*signal.row, sim.bases(), sim.cfg());
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
              configuration_signals()}) {
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
    const Format format = format_of(signal, sim);
    return {format.unit, format_text(format), format.one, format.zero};
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
    const Format scale = format_of(signal, *tick.sim);
    const int64_t raw = read_word(signal.word, place(signal.word, *tick.sim));
    return (static_cast<double>(raw) - scale.zero) * scale.one;
}

const char *unit_text(const SignalInfo &signal, const Simulation &sim)
{
    return format_of(signal, sim).unit;
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
    const Format scale = format_of(signal, sim);
    return std::round(si / scale.one + scale.zero);
}

void write_word(const Word &word, int64_t raw, const Seam &seam)
{
    unsigned char *const to = word.home == Word::Home::cfg ? at<unsigned char>(seam.cfg, word)
                                                           : at<unsigned char>(seam.drive, word);
    std::memcpy(to, &raw, word.bytes);
}

} // namespace nf
