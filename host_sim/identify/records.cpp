// SPDX-License-Identifier: MIT
#include "records.h"

#include "numbers.h"
#include "origin.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <iterator>
#include <sstream>

#include <fmt/format.h>

namespace nf::identify
{
namespace
{

const std::string FIRST = "identify";
const std::string RECORD = "=";
constexpr int64_t VERSION = 1;
constexpr int64_t TICKS_MOST = 131071;
constexpr int64_t QUARTER_MOST = 64;
constexpr double Q16 = 65536;

// The frame's angle is taken at the first tick of a window and two ticks behind its last one.
constexpr double TICKS_OF_TURN = 1;

// A quarter of the bus is summed.
constexpr double BUS_SHARE = 4;

// The numbers of a record, in their order.
enum Column {
    AXIS,
    CURRENT,
    SPEED,
    PULSE_D,
    PULSE_Q,
    QUARTER,
    TICKS,
    VOLTAGE_D,
    VOLTAGE_Q,
    CURRENT_D,
    CURRENT_Q,
    BUS,
    NOISE_A,
    NOISE_B,
    CHANGE_D,
    CHANGE_Q,
    CARRIED,
    TURN,
    ACROSS,
    PULL,
    COLUMNS
};
const char *const COLUMN_NAMES[COLUMNS] = {
    "axis", "current", "speed", "pulse_d", "pulse_q", "quarter", "ticks",
    "vd",   "vq",      "id",    "iq",      "bus",     "noise_a", "noise_b",
    "change_d", "change_q", "carried", "turn", "across", "pull"};
const char *const SCALE_NAMES[] = {"version",           "tick_ps",    "current_full_scale_ua",
                                   "bus_full_scale_uv", "pole_pairs", "speed_shift"};
const char *const KINDS[] = {"pulse", "catch", "still", "burst", "spin", "ramp", "hold", "coast"};

struct Line {
    Origin origin;
    std::vector<std::string> words; // the first says which line it is
};

std::string text_of(const Line &line)
{
    constexpr size_t SHOWN = 60;
    const std::string text = fmt::format("{}", fmt::join(line.words, " "));
    return text.size() > SHOWN ? text.substr(0, SHOWN) + "…" : text;
}

int64_t number_of(const Line &line, size_t word, const char *name, int64_t least, int64_t most)
{
    const std::string &text = line.words[word];
    const std::string key = line.words[0] + " " + name;
    int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const std::string allowed = fmt::format("a whole number, {} to {}", least, most);
    if (error != std::errc() || end != text.data() + text.size()) {
        fail(line.origin, key, text, "is no whole number", allowed);
    }
    if (number < least || number > most) {
        fail(line.origin, key, text, number < least ? "is too small" : "is too large", allowed);
    }
    return number;
}

void require_words(const Line &line, size_t count, const std::string &form)
{
    if (line.words.size() != count) {
        fail(line.origin, "record", text_of(line),
             fmt::format("has {} words", line.words.size()), form);
    }
}

Scales scales_of(const Line &line)
{
    constexpr int64_t POSITIVE = INT32_MAX;
    const int64_t most[] = {VERSION, POSITIVE, POSITIVE, POSITIVE, 50, 30};
    require_words(line, 1 + std::size(most),
                  fmt::format("identify {}", fmt::join(SCALE_NAMES, " ")));
    int64_t numbers[std::size(most)];
    for (size_t k = 0; k < std::size(most); k++) {
        numbers[k] = number_of(line, k + 1, SCALE_NAMES[k], k == 5 ? 0 : 1, most[k]);
    }
    Scales scales;
    scales.period_s = static_cast<double>(numbers[1]) * 1e-12;
    scales.current_a = 2 * static_cast<double>(numbers[2]) * 1e-6;
    scales.voltage_v = static_cast<double>(numbers[3]) * 1e-6;
    scales.pole_pairs = static_cast<int>(numbers[4]);
    scales.speed_rad_s = Q15 * std::exp2(static_cast<double>(numbers[5])) * TWO_PI /
                         STEPS_PER_TURN / scales.period_s;
    return scales;
}

using Numbers = std::array<int64_t, COLUMNS>;

Numbers numbers_of(const Line &line)
{
    require_words(line, 2 + COLUMNS,
                  fmt::format("= KIND {}", fmt::join(COLUMN_NAMES, " ")));
    if (std::find(std::begin(KINDS), std::end(KINDS), line.words[1]) == std::end(KINDS)) {
        fail(line.origin, "record", line.words[1], "is no kind of record",
             fmt::format("{}", fmt::join(KINDS, ", ")));
    }
    Numbers numbers{};
    for (size_t k = 0; k < COLUMNS; k++) {
        const int64_t least = k == TICKS || k == QUARTER ? 1 : (k == AXIS ? 0 : INT32_MIN);
        const int64_t most =
            k == AXIS ? 2 : (k == TICKS ? TICKS_MOST : (k == QUARTER ? QUARTER_MOST : INT32_MAX));
        numbers[k] = number_of(line, k + 2, COLUMN_NAMES[k], least, most);
    }
    return numbers;
}

Window window_of(const Line &line, const Scales &scales)
{
    const Numbers numbers = numbers_of(line);
    const auto of = [&](Column column) { return static_cast<double>(numbers[column]); };
    const double ticks = of(TICKS);
    const double volts = scales.voltage_v / Q15;
    const double amperes = scales.current_a / Q15;
    const double per_tick = TWO_PI / scales.period_s;
    Window w;
    w.line = line.origin.line;
    w.kind = line.words[1];
    w.axis = static_cast<int>(numbers[AXIS]);
    w.command_a = of(CURRENT) * amperes;
    w.command_rad_s = of(SPEED) / STEPS_PER_TURN * per_tick;
    w.pulse_d_v = of(PULSE_D) * volts;
    w.pulse_q_v = of(PULSE_Q) * volts;
    w.quarter = static_cast<int>(numbers[QUARTER]);
    w.ticks = static_cast<int>(numbers[TICKS]);
    w.voltage_v = std::complex<double>(of(VOLTAGE_D), of(VOLTAGE_Q)) * (volts / ticks);
    w.current_a = std::complex<double>(of(CURRENT_D), of(CURRENT_Q)) * (amperes / ticks);
    w.bus_v = of(BUS) * BUS_SHARE * volts / ticks;
    w.noise_a = (of(NOISE_A) + of(NOISE_B)) / 2 * amperes / ticks;
    w.change_d_a = of(CHANGE_D) * amperes;
    w.change_q_a = of(CHANGE_Q) * amperes;
    w.speed_rad_s = of(TURN) / Q16 / (ticks + TICKS_OF_TURN) * per_tick;
    w.torque_nm = 1.5 * scales.pole_pairs * volts * scales.current_a / scales.speed_rad_s *
                  of(PULL) / ticks;
    w.duration_s = ticks * scales.period_s;
    return w;
}

std::vector<std::string> words_of(const std::string &line)
{
    std::istringstream stream(line);
    return {std::istream_iterator<std::string>(stream), std::istream_iterator<std::string>()};
}

void take(Records &records, const Line &line)
{
    if (line.words[0] == FIRST) {
        if (records.scales.period_s > 0) {
            fail(line.origin, "record", text_of(line), "is a second first line",
                 "one measurement in a text");
        }
        records.scales = scales_of(line);
    } else if (records.scales.period_s > 0) {
        records.windows.push_back(window_of(line, records.scales));
    } else {
        fail(line.origin, "record", text_of(line), "comes before its scales",
             "a first line that begins with \"identify 1\"");
    }
}

} // namespace

std::vector<Window> Records::of(const std::string &kind) const
{
    std::vector<Window> found;
    std::copy_if(windows.begin(), windows.end(), std::back_inserter(found),
                 [&](const Window &window) { return window.kind == kind; });
    return found;
}

Records parse_records(const std::string &text, const std::string &name)
{
    Records records;
    std::istringstream lines(text);
    unsigned number = 0;
    for (std::string line; std::getline(lines, line);) {
        number++;
        const std::vector<std::string> words = words_of(line);
        if (!words.empty() && (words[0] == FIRST || words[0] == RECORD)) {
            take(records, {{name, number, Author::user}, words});
        }
    }
    if (records.windows.empty()) {
        fail({name, number, Author::user}, "record", "", "there is none",
             "a line \"identify 1 …\" and lines \"= KIND …\"");
    }
    return records;
}

} // namespace nf::identify
