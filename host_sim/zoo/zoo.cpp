// SPDX-License-Identifier: MIT
#include "zoo.h"

#include "binding.h"
#include "errors.h"
#include "times.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf::zoo
{
namespace
{

constexpr double TIMER_CLOCK_HZ = 170e6;
constexpr int ADC_BITS = 12;
// A thermistor of 10 kΩ at 25 °C above 10 kΩ.
const char *const TEMPERATURE_SENSOR =
    "temperature_points_c = [-20, 0, 20, 40, 60, 80, 100, 120]\n"
    "temperature_points_pct = [5.9, 14.28, 27.92, 44.72, 60.73, 73.31, 82.11, 87.91]\n"
    "temperature_max_c = 100\n";

// Rounded to what every machine's logarithm agrees on, and a data sheet prints no more.
std::string line(const char *key, double value)
{
    return fmt::format("{} = {:.6g}\n", key, value);
}

std::string text_line(const char *key, const std::string &value)
{
    return fmt::format("{} = \"{}\"\n", key, value);
}

std::string head(const Reference &reference)
{
    return fmt::format("# Motor {} of the zoo, class {}, seed {}.\n\n", reference.number,
                       reference.kind, reference.seed);
}

const Class &class_of(const Reference &reference)
{
    return *std::find_if(classes().begin(), classes().end(),
                         [&](const Class &kind) { return kind.name == reference.kind; });
}

Specimen specimen_of(const Reference &reference)
{
    return draw_specimen(Draw(reference.key()), class_of(reference));
}

// [model] and [plant]: the drive believes the files, the real motor and board are others. Nobody
// has measured what a leg's output and the cable hold.
std::string error_tables(const Errors &errors, const Specimen &specimen)
{
    const Board &board = specimen.board;
    return "[model]\n" + line("output_capacitance_f", -1) + line("dead_time_s", board.dead_time_s) +
           "\n[plant]\n" + line("resistance_scale", errors.resistance_scale) +
           line("inductance_scale", errors.inductance_scale) +
           line("saliency_scale", errors.saliency_scale) + line("flux_scale", errors.flux_scale) +
           line("inertia_scale", errors.inertia_scale) +
           line("coulomb_friction_nm", errors.coulomb_share * specimen.motor.rated_torque_nm) +
           line("cogging_pct", errors.cogging_pct) +
           fmt::format("cogging_order = {}\n", errors.cogging_order) +
           line("emf_5th_pct", errors.emf_5th_pct) + line("emf_7th_pct", errors.emf_7th_pct) +
           line("dead_time_s", board.dead_time_s * errors.dead_time_scale) +
           line("commutation_knee_a", errors.commutation_knee_a) +
           line("bus_ripple_pct", errors.bus_ripple_pct) +
           line("bus_ripple_hz", errors.bus_ripple_hz) +
           line("adc_noise_lsb", errors.adc_noise_lsb) +
           fmt::format("adc_offset_lsb = [{:.4g}, {:.4g}]\n", errors.adc_offset_lsb[0],
                       errors.adc_offset_lsb[1]) +
           fmt::format("adc_gain_error_pct = [{:.4g}, {:.4g}]\nadc_third_gain_error_pct = {:.4g}\n",
                       errors.adc_gain_error_pct[0], errors.adc_gain_error_pct[1],
                       errors.adc_third_gain_error_pct);
}

std::string binding_lines(const Binding &binding, const Board &board)
{
    constexpr double ns = 1e9;
    return line("adc_settling_ns", board.settling_s * ns) +
           line("adc_sampling_ns", binding.sampling_s * ns) +
           text_line("break_polarity", binding.falls ? "active_low" : "active_high") +
           line("shunt_ohm", binding.shunt_ohm) + line("amplifier_gain", binding.amplifier_gain) +
           line("amplifier_zero_v", binding.amplifier_zero_v) +
           fmt::format("pga_gain = {}\n", binding.pga_gain) +
           line("adc_reference_v", binding.adc_reference_v) +
           line("bus_divider", binding.bus_divider);
}

std::string entry(const char *list, double time_s, const char *key, double value)
{
    return fmt::format("\n[[scenario.{}]]\ntime_s = {:.4f}\n{} = {:g}\n", list, time_s, key, value);
}

std::string exact_file(const Reference &reference, const Names &names)
{
    const Draw draw(reference.key());
    const Specimen specimen = draw_specimen(draw, class_of(reference));
    const Times times = times_of(specimen.motor, specimen.board.pwm_frequency_hz);
    return head(reference) + text_line("motor", names.motor) + text_line("board", names.board) +
           text_line("tuning", "any") + "\n[model]\n" + line("output_capacitance_f", 0) +
           "\n[scenario]\n" +
           text_line("title", "start, 55 %, 100 % of rated speed, load step, stop, -10 %") +
           text_line("mode", "speed") + fmt::format("duration_s = {:.4f}\n", times.end) +
           fmt::format("evaluate_from_s = {:.4f}\n", times.started) +
           fmt::format("initial_angle_el_deg = {:.4g}\n",
                       draw.uniform("rotor angle", {-180, 180})) +
           "\n[[scenario.request]]\ntime_s = -60\nrun = false\n"
           "\n[[scenario.request]]\ntime_s = 0\nrun = true\n" +
           entry("command", times.started, "speed_pct", 55) +
           entry("command", times.full, "speed_pct", 100) +
           entry("command", times.stopped, "speed_pct", 0) +
           entry("command", times.reversed, "speed_pct", -100 * LAST_SPEED) +
           entry("load", times.loaded, "torque_pct", 50) +
           entry("load", times.unloaded, "torque_pct", 0) +
           "\n[accept.any]\nlocked = true\nlimit_cycle = false\n";
}

std::string user_file(const Reference &reference, const Names &names)
{
    const Specimen specimen = specimen_of(reference);
    const Draw draw(reference.key());
    const Errors errors = draw_errors(draw, specimen);
    const Times times = times_of(specimen.motor, specimen.board.pwm_frequency_hz);
    constexpr double per_cent = 100;
    return head(reference) + text_line("base", names.exact) + '\n' +
           error_tables(errors, specimen) +
           fmt::format("\n[scenario]\nseed = {}\n", draw.below("noise seed", 1U << 31U)) +
           entry("load", times.held, "torque_pct", errors.load_share * per_cent) +
           entry("load", times.full, "torque_pct", 0) +
           entry("load", times.loaded, "torque_pct", 50) +
           entry("load", times.unloaded, "torque_pct", 0);
}

} // namespace

std::string motor_file(const Reference &reference)
{
    const Motor motor = specimen_of(reference).motor;
    return head(reference) + "[motor]\n" + text_line("name", motor.name) +
           fmt::format("pole_pairs = {}\n", motor.pole_pairs) +
           line("resistance_ohm", motor.resistance_ohm) +
           line("inductance_d_h", motor.inductance_d_h) +
           line("inductance_q_h", motor.inductance_q_h) +
           line("flux_linkage_wb", motor.flux_linkage_wb) +
           line("rated_torque_nm", motor.rated_torque_nm) +
           line("rated_speed_rpm", motor.rated_speed_rpm) +
           line("max_speed_rpm", motor.max_speed_rpm) + line("max_current_a", motor.max_current_a) +
           line("inertia_kg_m2", motor.inertia_kg_m2) +
           line("viscous_friction_nm_s", motor.viscous_friction_nm_s);
}

std::string board_file(const Reference &reference)
{
    const Specimen specimen = specimen_of(reference);
    const Board &board = specimen.board;
    return head(reference) + "[board]\n" + text_line("name", board.name) +
           line("pwm_frequency_hz", board.pwm_frequency_hz) +
           line("timer_clock_hz", TIMER_CLOCK_HZ) + fmt::format("adc_bits = {}\n", ADC_BITS) +
           line("current_full_scale_a", board.current_full_scale_a) +
           line("bus_full_scale_v", board.bus_full_scale_v) +
           line("bus_nominal_v", board.bus_nominal_v) + line("bus_min_v", board.bus_min_v) +
           line("bus_max_v", board.bus_max_v) + line("overcurrent_a", board.overcurrent_a) +
           line("trip_a", board.trip_a) + line("current_sensors", 3) +
           line("offset_max_a", board.offset_max_a) +
           line("duty_margin_pct", board.duty_margin_pct) + line("dead_time_s", board.dead_time_s) +
           line("device_drop_v", board.device_drop_v) +
           fmt::format("offset_samples_log2 = {}\n", board.offset_samples_log2) +
           TEMPERATURE_SENSOR + "\n[hal]\n" +
           binding_lines(draw_binding(Draw(reference.key()), specimen), board);
}

std::string scenario_file(const Reference &reference, const Names &names)
{
    return reference.user ? user_file(reference, names) : exact_file(reference, names);
}

std::string imperfection_file(const Reference &reference)
{
    const Specimen specimen = specimen_of(reference);
    return head(reference) + error_tables(draw_errors(Draw(reference.key()), specimen), specimen);
}

std::vector<File> files(const Reference &reference)
{
    const Names names = {"./motor.toml", "./board.toml", "./exact.toml"};
    Reference exact = reference;
    exact.user = false;
    Reference user = reference;
    user.user = true;
    return {
        {"motor.toml", motor_file(exact)},
        {"board.toml", board_file(exact)},
        {"exact.toml", scenario_file(exact, names)},
        {"user.toml", scenario_file(user, names)},
    };
}

} // namespace nf::zoo
