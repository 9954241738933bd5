// SPDX-License-Identifier: MIT
#include "hal_header.h"

#include "g4_family.h"
#include "g4_header.h"
#include "limit.h"
#include "schema.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double NS = 1e-9;
// No half bridge switches faster.
constexpr double DEAD_TIME_MIN_NS = 10.0;
// A product of decimals may lie this share above the whole number that it is.
constexpr double PRODUCT_ERROR = 1e-9;
constexpr double DAC_COUNTS = 4096.0;
// Two statements of one scale, each rounded by hand, agree within this share.
constexpr double SCALE_TOLERANCE = 0.02;
// What the binding of hal/stm32g4 can set its chip to; its board.c asserts the same.
constexpr int G4_ADC_BITS = 12;
constexpr double G4_DEAD_TIME_TICKS = 1008;
constexpr double G4_SAMPLING_NS = 1100;
// Its oscillator may be off by 1 % (hal/stm32g4/clock.h), and both sides of a line understand
// each other within 2 %.
constexpr double G4_BAUD_ERROR = 0.01;
// Bytes that its receiver holds. The background takes them once a tick.
constexpr double G4_FIFO_BYTES = 8;
constexpr double LINE_BITS = 10; // of a byte

// Half of the shortest time for which a low side is commanded on, around the instant of sampling:
// the largest duty is 1 − margin/2.
double half_low_side_s(const BoardSettings &board)
{
    return board.duty_margin_pct / 100.0 / 4.0 / board.pwm_frequency_hz;
}

Origin board_file(const Config &config)
{
    return {config.origins.at("board.name").file, 0};
}

void need(bool holds, const Config &config, const std::string &key, double value,
          const std::string &problem, const std::string &allowed)
{
    if (!holds) {
        const auto origin = config.origins.find(key);
        fail(origin == config.origins.end() ? board_file(config) : origin->second, key,
             fmt::format("{:.6g}", value), problem, allowed);
    }
}

bool is_g4(const Config &config)
{
    return config.hal.chip != "other";
}

// With a line of the gate driver in place of comparators.
bool has_line(const Config &config)
{
    return is_g4(config) && !config.hal.break_pin.empty();
}

// Keys of [hal] that each binding needs.
const std::vector<std::string> NEEDED_BY_ALL = {
    "hal.adc_settling_ns", "hal.adc_sampling_ns", "hal.break_polarity",
    "hal.shunt_ohm",       "hal.amplifier_gain",  "hal.amplifier_zero_v",
    "hal.pga_gain",        "hal.adc_reference_v", "hal.bus_divider"};
// What hal/stm32g4 needs besides.
const std::vector<std::string> NEEDED_BY_G4 = {"hal.gate_high_pins", "hal.shunt_pins",
                                               "hal.bus_pin", "hal.temperature_pin",
                                               "hal.serial_pins"};

bool is_in(const std::vector<std::string> &names, const std::string &name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

// The defaults of the temperature sensor are for simulated power stages, which may also do without
// comparators; the warning follows from its limit. A gate driver with a fault line has a limit of
// its own.
bool is_needed(const Config &config, const Field &field)
{
    const std::string name = field.name();
    return (is_in(NEEDED_BY_ALL, name) && field.acting.holds(config)) ||
           (is_g4(config) && is_in(NEEDED_BY_G4, name)) || name == "board.dead_time_s" ||
           (name == "board.trip_a" && !has_line(config)) ||
           (name.rfind("board.temperature_", 0) == 0 && name != "board.temperature_warn_c");
}

// A forgotten chip must not leave the pins unchecked.
void check_chip_is_named(const Config &config)
{
    if (config.origins.count("hal.chip") == 0 && config.origins.count("hal.gate_high_pins") != 0) {
        fail(board_file(config), "hal.chip", "", "is missing, and hal.gate_high_pins needs it",
             g4_chip_names());
    }
}

void check_complete(const Config &config)
{
    check_chip_is_named(config);
    std::vector<const Field *> lacking;
    for (const Field &field : schema()) {
        if (is_needed(config, field) && config.origins.count(field.name()) == 0) {
            lacking.push_back(&field);
        }
    }
    if (!lacking.empty()) {
        refuse_missing(board_file(config), lacking, ", and a hardware binding needs ");
    }
}

// The chip's amplifiers lie behind the comparators' inputs.
bool amplifies(const Config &config)
{
    return is_g4(config) && config.hal.pga_gain > 1;
}

void check_gains(const Config &config)
{
    const HalSettings &hal = config.hal;
    need((hal.pga_gain & (hal.pga_gain - 1)) == 0, config, "hal.pga_gain", hal.pga_gain,
         "is no gain of the amplifier", "1, 2, 4, 8, 16, 32 or 64");
    need(hal.amplifier_gain != 0, config, "hal.amplifier_gain", hal.amplifier_gain, "is no gain",
         "a positive or negative number");
    need(!amplifies(config) || std::fabs(hal.amplifier_gain) <= hal.pga_gain, config,
         "hal.amplifier_gain", hal.amplifier_gain,
         "is more than the chip's amplifiers have, and resistors before them only take away",
         fmt::format("-{0} to {0}: hal.pga_gain", hal.pga_gain));
}

double dead_time_ticks(const BoardSettings &board)
{
    return std::ceil(board.dead_time_s * board.timer_clock_hz * (1 - PRODUCT_ERROR));
}

void check_chip(const Config &config)
{
    const BoardSettings &board = config.board;
    const HalSettings &hal = config.hal;
    if (!is_g4(config)) {
        return;
    }
    if (find_g4_chip(hal.chip) == nullptr) {
        fail(config.origins.at("hal.chip"), "hal.chip", '"' + hal.chip + '"',
             "is no chip that hal/stm32g4 serves", g4_chip_names() + ", or other");
    }
    need(std::round(board.timer_clock_hz) == G4_CLOCK_HZ, config, "board.timer_clock_hz",
         board.timer_clock_hz, "is not the clock of this chip's timer",
         fmt::format("{:.0f} Hz", G4_CLOCK_HZ));
    need(board.adc_bits == G4_ADC_BITS, config, "board.adc_bits", board.adc_bits,
         "is not what this chip's converters have", fmt::format("{} bit", G4_ADC_BITS));
    need(dead_time_ticks(board) <= G4_DEAD_TIME_TICKS, config, "board.dead_time_s",
         board.dead_time_s, "is longer than this chip's timer makes",
         fmt::format("at most {} s", limit_number({true, G4_DEAD_TIME_TICKS / G4_CLOCK_HZ})));
    need(std::ceil(hal.adc_sampling_ns) <= G4_SAMPLING_NS, config, "hal.adc_sampling_ns",
         hal.adc_sampling_ns, "is longer than this chip samples",
         fmt::format("at most {:g} ns, 47.5 cycles of its converters", G4_SAMPLING_NS));
}

// Throws for an input that is set and has no pin. `key` is that of the input, `value` what is set.
void need_pin(const Config &config, const std::string &key, const char *value, const char *pin_key,
              const std::string &pin)
{
    if (pin.empty()) {
        const auto origin = config.origins.find(key);
        fail(origin == config.origins.end() ? board_file(config) : origin->second, key,
             fmt::format("\"{}\"", value),
             fmt::format("needs {}, and this board has none", pin_key),
             "\"none\", or a board with such a pin");
    }
}

void check_input(const Config &config)
{
    const InputSettings &input = config.tuning.input;
    const HalSettings &hal = config.hal;
    if (!is_g4(config) || input.kind == InputKind::none) {
        return;
    }
    if (input.kind == InputKind::voltage) {
        need_pin(config, "input.kind", "voltage", "hal.throttle_pin", hal.throttle_pin);
    } else {
        need_pin(config, "input.kind", input.kind == InputKind::dshot ? "dshot" : "rc_pulse",
                 "hal.pulse_pin", hal.pulse_pin);
    }
    if (input.button != InputButton::none) {
        need_pin(config, "input.button",
                 input.button == InputButton::enable ? "enable" : "start_stop", "hal.button_pin",
                 hal.button_pin);
    }
}

// The rate of a whole number of the chip's cycles per bit, over the rate that is asked for, less
// one.
double baud_error(double baud)
{
    return G4_CLOCK_HZ / std::round(G4_CLOCK_HZ / baud) / baud - 1;
}

void check_line(const Config &config)
{
    const double baud = config.board.baud;
    const double most = G4_FIFO_BYTES * LINE_BITS * config.board.pwm_frequency_hz;
    if (!is_g4(config)) {
        return;
    }
    need(std::fabs(baud_error(baud)) <= G4_BAUD_ERROR, config, "board.baud", baud,
         fmt::format("is missed by {:.2g} % by this chip's divider", 100 * baud_error(baud)),
         fmt::format("170e6/n bit/s, within {:g} %", 100 * G4_BAUD_ERROR));
    need(baud <= most, config, "board.baud", baud,
         "brings more bytes in a control tick than the receiver of this chip holds",
         fmt::format("at most {:.0f} bit/s at board.pwm_frequency_hz = {:g}", std::floor(most),
                     config.board.pwm_frequency_hz));
}

void check_timing(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double dead_ns = config.board.dead_time_s / NS;
    const double half = half_low_side_s(config.board) / NS;
    const std::string window = fmt::format(
        "{:.0f} ns, half of the shortest low-side on-time at board.duty_margin_pct = {:g} and "
        "board.pwm_frequency_hz = {:g}",
        std::floor(half), config.board.duty_margin_pct, config.board.pwm_frequency_hz);
    need(dead_ns >= DEAD_TIME_MIN_NS, config, "board.dead_time_s", config.board.dead_time_s,
         "lets both switches of a leg conduct", fmt::format("at least {:g} ns", DEAD_TIME_MIN_NS));
    need(dead_ns < half, config, "board.dead_time_s", config.board.dead_time_s,
         "is longer than the PWM period allows", "below " + window);
    if (hal.current_position == CurrentPosition::in_line) {
        return; // its current can be sampled at any time
    }
    need(dead_ns + hal.adc_settling_ns <= half, config, "hal.adc_settling_ns", hal.adc_settling_ns,
         "does not fit into the low-side on-time",
         fmt::format("at most {:.0f} ns: with board.dead_time_s = {:g} it has to end within {}",
                     std::floor(half - dead_ns), config.board.dead_time_s, window));
    need(hal.adc_sampling_ns <= half, config, "hal.adc_sampling_ns", hal.adc_sampling_ns,
         "does not fit into the low-side on-time", "at most " + window);
}

void check_scale(const Config &config, const std::string &key, double given, double measured,
                 const std::string &formula)
{
    need(std::fabs(given - measured) <= SCALE_TOLERANCE * measured, config, key, given,
         "is not what the converter sees",
         fmt::format("{:.5g} within 2 %, from {}", measured, formula));
}

double volts_per_ampere(const HalSettings &hal)
{
    return hal.shunt_ohm * std::fabs(hal.amplifier_gain);
}

void check_scales(const Config &config)
{
    const HalSettings &hal = config.hal;
    check_scale(config, "board.current_full_scale_a", config.board.current_full_scale_a,
                hal.adc_reference_v / 2 / volts_per_ampere(hal),
                "hal.adc_reference_v/2/(hal.shunt_ohm·hal.amplifier_gain)");
    check_scale(config, "board.bus_full_scale_v", config.board.bus_full_scale_v,
                hal.adc_reference_v / hal.bus_divider, "hal.adc_reference_v/hal.bus_divider");
    need(hal.amplifier_zero_v < hal.adc_reference_v, config, "hal.amplifier_zero_v",
         hal.amplifier_zero_v, "is beyond the converter's range",
         fmt::format("below {:g} V", hal.adc_reference_v));
    const double needed_a = config.board.overcurrent_a + config.board.offset_max_a;
    const double needed_v = needed_a * volts_per_ampere(hal);
    need(hal.amplifier_zero_v > needed_v && hal.adc_reference_v - hal.amplifier_zero_v > needed_v,
         config, "hal.amplifier_zero_v", hal.amplifier_zero_v,
         "leaves the converter blind to over-current in one direction",
         fmt::format("{:.3g} V to {:.3g} V, for {:g} A both ways", needed_v,
                     hal.adc_reference_v - needed_v, needed_a));
}

// DS12589, the most each: offset of an amplifier at its input, its gain, and resistors of 1 % that
// make the bias.
constexpr double AMPLIFIER_OFFSET_V = 3e-3;
constexpr double AMPLIFIER_GAIN_ERROR = 0.02;
constexpr double BIAS_ERROR = 0.02;

// A healthy board may have this offset, and has to start with it.
void check_offset(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double volts = AMPLIFIER_OFFSET_V * hal.pga_gain +
                         (AMPLIFIER_GAIN_ERROR + BIAS_ERROR) * hal.amplifier_zero_v;
    const double least = volts / volts_per_ampere(hal);
    need(
        !amplifies(config) || config.board.offset_max_a >= least, config, "board.offset_max_a",
        config.board.offset_max_a, "is less than a healthy board may have",
        fmt::format("at least {} A: an amplifier's offset of 3 mV, its gain within 2 %, and a bias "
                    "of resistors of 1 %",
                    limit_number({false, least})));
}

// What hysteresis and offset of the comparator together may come to, with a margin of two.
constexpr double RISE_MIN_V = 0.025;
// A comparator of an STM32G4 trips within this distance of its level: DS12589, offset.
constexpr double G4_TRIP_EARLY_V = 0.003;
constexpr double G4_TRIP_LATE_V = 0.009;

// The comparators look at the pin before the programmable amplifier.
double trip_level_v(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double rise = volts_per_ampere(hal) * config.board.trip_a;
    const double output =
        hal.amplifier_zero_v + (hal.break_polarity == Polarity::active_low ? -rise : rise);
    return output / hal.pga_gain;
}

double rise_per_ampere_v(const HalSettings &hal)
{
    return volts_per_ampere(hal) / hal.pga_gain;
}

// The comparators look before the amplifiers, so they see more than the converters. But a trip far
// beyond all that is measured is a mistake.
constexpr double TRIP_BEYOND_SCALE = 2;

void check_trip(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double level = trip_level_v(config);
    const double trip_a = config.board.trip_a;
    const double rise_per_ampere = rise_per_ampere_v(hal);
    need(trip_a * rise_per_ampere >= RISE_MIN_V, config, "board.trip_a", trip_a,
         "is within offset and hysteresis of the comparator",
         fmt::format("at least {} A", limit_number({false, RISE_MIN_V / rise_per_ampere})));
    const double largest = hal.adc_reference_v * (DAC_COUNTS - 1) / DAC_COUNTS;
    const double room = hal.break_polarity == Polarity::active_low
                            ? hal.amplifier_zero_v
                            : largest * hal.pga_gain - hal.amplifier_zero_v;
    const double most = std::min(room / volts_per_ampere(hal),
                                 TRIP_BEYOND_SCALE * config.board.current_full_scale_a);
    need(level > 0 && level <= largest && trip_a <= most, config, "board.trip_a", trip_a,
         "is beyond what this power stage can see",
         fmt::format("at most {} A, from amplifiers, reference and {:g} times "
                     "board.current_full_scale_a",
                     limit_number({true, most}), TRIP_BEYOND_SCALE));
}

void check_early_trip(const Config &config)
{
    const double trip_a = config.board.trip_a;
    const double max_a = config.motor.max_current_a;
    const double early_a = G4_TRIP_EARLY_V / rise_per_ampere_v(config.hal);
    need(!is_g4(config) || trip_a >= max_a + early_a, config, "board.trip_a", trip_a,
         "lets a comparator trip while the motor takes what it may",
         fmt::format("at least {} A: motor.max_current_a = {:g}, and {:.3g} A for the "
                     "comparator's offset",
                     limit_number({false, max_a + early_a}), max_a, early_a));
}

// A shoot-through, or a short circuit to the bus, sends a current from the phase through the shunt
// to ground: a current out of the motor. The comparators have to be on that side.
void check_side(const Config &config)
{
    const HalSettings &hal = config.hal;
    const bool rises = hal.amplifier_gain < 0;
    const bool above = hal.break_polarity == Polarity::active_high;
    if (is_g4(config) && hal.current_position == CurrentPosition::low_side && rises != above) {
        fail(config.origins.at("hal.break_polarity"), "hal.break_polarity",
             above ? "\"active_high\"" : "\"active_low\"",
             "lets the comparators look away from a current that a short circuit sends to ground",
             fmt::format("\"{}\" with hal.amplifier_gain = {:g} and low-side shunts",
                         rises ? "active_high" : "active_low", hal.amplifier_gain));
    }
}

// Where one of many chips trips.
std::string trip_range(const Config &config)
{
    const double trip_a = config.board.trip_a;
    const double rise_per_ampere = rise_per_ampere_v(config.hal);
    return !is_g4(config) ? ""
                          : fmt::format(", which trips from {:.3g} to {:.3g} A",
                                        trip_a - G4_TRIP_EARLY_V / rise_per_ampere,
                                        trip_a + G4_TRIP_LATE_V / rise_per_ampere);
}

// What the image needs beside the flight recorder's ring, and what a command pin needs besides. The
// linker knows it exactly.
constexpr int BESIDE_RING_BYTES = 15200;
constexpr int PULSES_BYTES = 448;
constexpr int RING_ENTRY_BYTES = 16;

void check_ring(const Config &config)
{
    const int ram = find_g4_chip(config.hal.chip)->ram_kib * 1024;
    const int pulses = config.hal.pulse_pin.empty() ? 0 : PULSES_BYTES;
    const int most = (ram - BESIDE_RING_BYTES - pulses) / RING_ENTRY_BYTES;
    const double entries = config.board.recorder_entries;
    need(entries <= most, config, "board.recorder_entries", entries,
         fmt::format("does not fit the {} KiB of RAM of {}", ram / 1024, config.hal.chip),
         fmt::format("at most {}", most));
}

// One line `#define HAL_NAME (value) /* meaning */`.
std::string define(const char *name, double value, const char *suffix, const std::string &meaning)
{
    return fmt::format("#define HAL_{} ({:.0f}{}) /* {} */\n", name, std::round(value), suffix,
                       meaning);
}

std::string flag(const char *name, bool value, const std::string &meaning)
{
    return fmt::format("#define HAL_{} ({}) /* {} */\n", name, value ? "true" : "false", meaning);
}

std::string timer_lines(const Config &config)
{
    const BoardSettings &board = config.board;
    const double clock = board.timer_clock_hz;
    return define("TIMER_CLOCK_HZ", clock, "U", "board.timer_clock_hz") +
           define("TIMER_COUNTS", clock / (2 * board.pwm_frequency_hz), "U",
                  fmt::format("half a period at {:g} Hz", board.pwm_frequency_hz)) +
           define("DEAD_TIME_TICKS", dead_time_ticks(board), "U",
                  fmt::format("{:g} ns, rounded up", board.dead_time_s / NS));
}

std::string sensing_lines(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double counts = std::ldexp(1.0, config.board.adc_bits);
    const double zero = hal.amplifier_zero_v / hal.adc_reference_v * counts;
    return define("ADC_BITS", config.board.adc_bits, "U", "board.adc_bits") +
           define("ADC_SAMPLING_NS", std::ceil(hal.adc_sampling_ns), "U", "at least") +
           define("AMPLIFIER_ZERO", zero, "U",
                  fmt::format("counts without current, {:g} V", hal.amplifier_zero_v)) +
           flag("AMPLIFIER_INVERTS", hal.amplifier_gain < 0, "current into the motor counts down") +
           define("PGA_GAIN", hal.pga_gain, "U", "hal.pga_gain");
}

std::string trip_lines(const Config &config)
{
    const HalSettings &hal = config.hal;
    const double level = trip_level_v(config);
    const std::string count =
        has_line(config) ? "" // the gate driver has a limit of its own
                         : define("TRIP_COUNT", level / hal.adc_reference_v * DAC_COUNTS, "U",
                                  fmt::format("of 4096: {:g} A is {:.4g} V at the comparator{}",
                                              config.board.trip_a, level, trip_range(config)));
    return count +
           flag("TRIP_BELOW", hal.break_polarity == Polarity::active_low, "hal.break_polarity");
}

// What a configuration has to fit.
std::string power_stage_lines(const Config &config)
{
    return timer_lines(config) + sensing_lines(config) + trip_lines(config);
}

std::string line_lines(const Config &config)
{
    return define("BAUD", config.board.baud, "U", "board.baud");
}

} // namespace

std::string hal_facts(const Config &config)
{
    std::string facts;
    if (config.origins.count("hal.shunt_ohm") != 0) {
        std::istringstream lines(power_stage_lines(config));
        for (std::string line; std::getline(lines, line);) {
            facts += line.substr(0, line.find(" /*")) + '\n';
        }
    }
    return facts;
}

std::string make_hal_header(const Config &config)
{
    check_complete(config);
    check_gains(config);
    check_timing(config);
    check_chip(config);
    check_line(config);
    check_input(config);
    check_scales(config);
    check_offset(config);
    if (!has_line(config)) {
        check_trip(config);
        check_early_trip(config);
        check_side(config);
    }
    (void)build(config); // a binding is for a drive that the firmware takes
    return fmt::format(
        "/* Made by nfconfig from motor, board and tuning file. Change those and make it "
        "again. */\n"
        "#ifndef HAL_CONFIG_H\n#define HAL_CONFIG_H\n\n"
        "{}{}{}"
        "\n#endif\n",
        power_stage_lines(config), line_lines(config), is_g4(config) ? g4_header(config) : "");
}

std::string make_hal_memory(const Config &config)
{
    (void)make_hal_header(config);
    if (config.origins.count("hal.chip") == 0) {
        fail(board_file(config), "hal.chip", "", "is missing, and hal/stm32g4 needs it",
             g4_chip_names());
    }
    if (!is_g4(config)) {
        fail(config.origins.at("hal.chip"), "hal.chip", "\"other\"",
             "has a linker script of its own", g4_chip_names());
    }
    check_ring(config);
    return g4_memory(config);
}

} // namespace nf
