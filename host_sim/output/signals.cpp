// SPDX-License-Identifier: MIT
#include "signals.h"

#include "measured.h"
#include "names.h"
#include "numbers.h"
#include "suggest.h"

extern "C" {
#include "estimate.h"
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
constexpr double RPM_PER_RAD_S = 30.0 / PI;
constexpr double DEG_PER_RAD = 180.0 / PI;
constexpr double DEG_PER_STEP = 360.0 / Q32;

double speed_command(const Tick &t)
{
    return t.mode == DriveMode::speed
               ? t.command
               : t.sim->bases().rpm_from_step(t.sim->drive().motion.speed_reference);
}

double position_estimated(const Tick &t)
{
    const double turns = static_cast<double>(t.position_estimate_q32 - t.position_zero_q32) / Q32;
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
                                        t.sim->drive().rotor.observer.speed);
}

// β, by which the voltage is ahead of the q axis, in its own direction; 0 with current regulators.
double lead(const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    const dq_t &v = drive.control.voltage;
    const double along = drive.voltage_drive.magnitude < 0 ? -1 : 1;
    return drive.voltage_drive.active ? std::atan2(-v.d * along, v.q * along) * DEG_PER_RAD : 0.0;
}

double current_of(const Tick &t, int32_t q15)
{
    return q15 / Q15 * t.sim->bases().current_a;
}

double voltage_of(const Tick &t, int32_t q15)
{
    return q15 / Q15 * t.sim->bases().voltage_v;
}

ab_t current_ab(const Tick &t)
{
    const sample_t sample = measured_sample(*t.sim);
    return transforms_clarke(sample.phase_a, sample.phase_b);
}

// What the observer is given.
ab_t voltage_applied(const Tick &t)
{
    return estimate_applied_voltage(t.ratio_acted, t.bus_before, t.sim->drive().bus);
}

double voltage_limit(const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    return voltage_of(t, modulator_limit(&drive.cfg->modulator, drive.bus));
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

// A member's name, place and type are one thing: only the preprocessor can tell all three from one
// mention.
#define WORD(name, home, type, member, quantity) \
    word<std::remove_reference_t<decltype(std::declval<type &>().member)>>( \
        name, Quantity::quantity, Word::Home::home, offsetof(type, member), #member)
#define IN(member, quantity) WORD("in." #member, in, drive_in_t, member, quantity)
#define OUT(member, quantity) WORD("out." #member, out, drive_out_t, member, quantity)
#define DRIVE(member, quantity) WORD("drive." #member, drive, drive_t, member, quantity)
#define ALIAS(name, member, quantity) WORD(name, drive, drive_t, member, quantity)

// θ̂ and ω̂, and what is measured or asked for along them.
SignalInfo of_rotor(SignalInfo signal)
{
    signal.known = [](const drive_t &drive) { return drive_knows_rotor(&drive); };
    return signal;
}

SignalInfo of_control(SignalInfo signal)
{
    signal.known = [](const drive_t &drive) { return drive_is_controlled(drive.state); };
    return signal;
}

// In the frame of an imposed vector.
SignalInfo of_vector(SignalInfo signal)
{
    signal.known = [](const drive_t &drive) {
        return drive_is_controlled(drive.state) && drive.state != DRIVE_STATE_RUN;
    };
    return signal;
}

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
        of_rotor(
            derived("speed_estimated_rpm", Q::speed_rpm,
                    [](const Tick &t) { return t.sim->bases().rpm_from_step(t.speed_estimate); })),
        of_control(ALIAS("speed_reference_rpm", motion.speed_loop.reference, speed_step)),
        derived("position_command_rad", Q::angle_rad,
                [](const Tick &t) { return t.mode == DriveMode::position ? t.command : 0.0; }),
        derived("position_rad", Q::angle_rad, [](const Tick &t) { return t.truth.theta_mech_rad; }),
        of_rotor(derived("position_estimated_rad", Q::angle_rad, position_estimated)),
        derived("angle_el_deg", Q::angle_deg,
                [](const Tick &t) { return t.truth.theta_el_rad * DEG_PER_RAD; }),
        of_rotor(derived("angle_estimated_el_deg", Q::angle_deg, angle_estimated)),
        of_rotor(derived("angle_error_el_deg", Q::angle_deg, angle_error_deg)),
        derived("i_q_a", Q::current_a, [](const Tick &t) { return t.truth.i_q_a; }),
        of_control(derived("i_q_measured_a", Q::current_a,
                           [](const Tick &t) { return current_of(t, measured(t).along_rotor.q); })),
        of_control(ALIAS("i_q_estimated_a", rotor.observer.current.q, current_q15)),
        of_control(ALIAS("i_q_reference_a", control.current_ref.q, current_q15)),
        derived("i_d_a", Q::current_a, [](const Tick &t) { return t.truth.i_d_a; }),
        of_control(derived("i_d_measured_a", Q::current_a,
                           [](const Tick &t) { return current_of(t, measured(t).along_rotor.d); })),
        of_control(ALIAS("i_d_estimated_a", rotor.observer.current.d, current_q15)),
        derived("i_a_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[0]; }),
        derived("i_b_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[1]; }),
        derived("i_c_a", Q::current_a, [](const Tick &t) { return t.truth.i_abc_a[2]; }),
        derived("i_alpha_a", Q::current_a,
                [](const Tick &t) { return current_of(t, current_ab(t).alpha); }),
        derived("i_beta_a", Q::current_a,
                [](const Tick &t) { return current_of(t, current_ab(t).beta); }),
        derived("v_alpha_applied_v", Q::voltage_v,
                [](const Tick &t) { return voltage_of(t, voltage_applied(t).alpha); }),
        derived("v_beta_applied_v", Q::voltage_v,
                [](const Tick &t) { return voltage_of(t, voltage_applied(t).beta); }),
        derived("v_limit_v", Q::voltage_v, voltage_limit),
        of_control(ALIAS("v_d_v", control.voltage.d, voltage_q15)),
        of_control(ALIAS("v_q_v", control.voltage.q, voltage_q15)),
        derived("duty_a", Q::share, [](const Tick &t) { return duty(t, 0); }),
        derived("duty_b", Q::share, [](const Tick &t) { return duty(t, 1); }),
        derived("duty_c", Q::share, [](const Tick &t) { return duty(t, 2); }),
        derived("bus_v", Q::voltage_v, [](const Tick &t) { return t.truth.bus_v; }),
        derived("torque_command_nm", Q::torque_nm,
                [](const Tick &t) { return t.mode == DriveMode::torque ? t.command : 0.0; }),
        derived("load_torque_nm", Q::torque_nm, [](const Tick &t) { return t.load_nm; }),
        derived("torque_nm", Q::torque_nm, [](const Tick &t) { return t.truth.torque_nm; }),
    };
}

// Measured values that the drive does not store.
std::vector<SignalInfo> measured_signals()
{
    using Q = Quantity;
    return {
        derived("i_a_measured_a", Q::current_a,
                [](const Tick &t) { return current_of(t, measured_sample(*t.sim).phase_a); }),
        derived("i_b_measured_a", Q::current_a,
                [](const Tick &t) { return current_of(t, measured_sample(*t.sim).phase_b); }),
        of_vector(derived("i_d_vector_a", Q::current_a,
                          [](const Tick &t) { return current_of(t, measured(t).along_vector.d); })),
        of_vector(derived("i_q_vector_a", Q::current_a,
                          [](const Tick &t) { return current_of(t, measured(t).along_vector.q); })),
    };
}

std::vector<SignalInfo> input_signals()
{
    return {
        IN(adc_ia, adc_current),        IN(adc_ib, adc_current),     IN(adc_bus, adc_bus),
        IN(adc_temperature, adc_plain), IN(flags, number),           IN(command.target, number),
        IN(command.mode, number),       IN(command.request, number), IN(angle, shaft_q16),
    };
}

std::vector<SignalInfo> state_signals()
{
#define FIELD(path, lowest, highest, quantity) DRIVE(path, quantity),
#define FREE(path, quantity) DRIVE(path, quantity),
    return {
#include "state.def"
    };
#undef FIELD
#undef FREE
}

std::vector<SignalInfo> output_signals()
{
    return {
        derived("weight_change_rpm", Quantity::speed_rpm, weight_change),
        derived("lead_el_deg", Quantity::angle_deg, lead),
        OUT(compare.phase[0], compare),
        OUT(compare.phase[1], compare),
        OUT(compare.phase[2], compare),
        OUT(gate_enable, flag),
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

#undef WORD
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
             {measured_signals(), input_signals(), state_signals(), output_signals(),
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

namespace
{

double value_in_state(const SignalInfo &signal, const Tick &tick)
{
    if (signal.value != nullptr) {
        return signal.value(tick);
    }
    const Format scale = format_of(signal, *tick.sim);
    const int64_t raw = read_word(signal.word, place(signal.word, *tick.sim));
    return (static_cast<double>(raw) - scale.zero) * scale.one;
}

} // namespace

double si_value(const SignalInfo &signal, const Tick &tick)
{
    const bool known = signal.known == nullptr || signal.known(tick.sim->drive());
    return known ? value_in_state(signal, tick) : std::nan("");
}

bool is_told(const SignalInfo &signal, const Tick &tick)
{
    return !std::isnan(value_in_state(signal, tick));
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
