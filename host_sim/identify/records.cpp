// SPDX-License-Identifier: MIT
#include "records.h"

#include "config.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <sstream>

#include <fmt/format.h>

namespace nf::identify
{
namespace
{

constexpr double PI = 3.14159265358979323846;
constexpr double Q15 = 32768;
constexpr double Q16 = 65536;
constexpr double STEPS = 4294967296; // of a turn
constexpr std::size_t SCALE_NUMBERS = 6;
constexpr std::size_t RECORD_NUMBERS = 20;

struct Place {
    const std::string &name;
    std::size_t line;

    [[noreturn]] void refuse(const std::string &what) const
    {
        throw ConfigError(fmt::format("{}:{}: {}", name, line, what));
    }
};

// All words from `first` on as whole numbers.
std::vector<double> numbers_of(const std::vector<std::string> &words, std::size_t first,
                               std::size_t count, const Place &place)
{
    if (words.size() != first + count) {
        place.refuse(fmt::format("{} numbers, expected {}: the line is not complete",
                                 words.size() - std::min(first, words.size()), count));
    }
    std::vector<double> numbers;
    for (std::size_t k = first; k < words.size(); k++) {
        long value = 0;
        const char *const end = words[k].data() + words[k].size();
        const auto [stop, error] = std::from_chars(words[k].data(), end, value);
        if (error != std::errc() || stop != end) {
            place.refuse(fmt::format("\"{}\" is not a whole number", words[k]));
        }
        numbers.push_back(static_cast<double>(value));
    }
    return numbers;
}

Scales scales_of(const std::vector<double> &n, const Place &place)
{
    constexpr double pico = 1e-12;
    constexpr double micro = 1e-6;
    if (n[0] != 1) {
        place.refuse(fmt::format("records of version {:g}, this program reads version 1", n[0]));
    }
    if (n[1] <= 0 || n[2] <= 0 || n[3] <= 0 || n[4] <= 0) {
        place.refuse("a scale is not above 0");
    }
    Scales scales;
    scales.period_s = n[1] * pico;
    scales.current_a = 2 * n[2] * micro;
    scales.voltage_v = n[3] * micro;
    scales.pole_pairs = static_cast<int>(n[4]);
    scales.speed_el_rad_s = Q15 * std::exp2(n[5]) * 2 * PI / STEPS / scales.period_s;
    return scales;
}

Record record_of(const std::string &kind, const std::vector<double> &n, const Scales &scales,
                 const Place &place)
{
    const double ticks = n[6];
    if (ticks < 1 || n[5] < 1 || n[0] < 0 || n[0] > 2) {
        place.refuse("an axis, a number of ticks or of a quarter that no record has");
    }
    const double volts = scales.voltage_v / Q15;
    const double amperes = scales.current_a / Q15;
    Record r;
    r.kind = kind;
    r.axis = static_cast<int>(n[0]);
    r.current_a = n[1] * amperes;
    r.across = n[4] > 0;
    r.pulse_v = (r.across ? n[4] : n[3]) * volts;
    r.quarter_ticks = static_cast<int>(n[5]);
    r.ticks = ticks;
    r.voltage_v = std::complex<double>(n[7], n[8]) * volts / ticks;
    r.i_a = std::complex<double>(n[9], n[10]) * amperes / ticks;
    r.bus_v = 4 * n[11] * volts / ticks;
    r.noise_a[0] = n[12] * amperes / ticks;
    r.noise_a[1] = n[13] * amperes / ticks;
    r.change_a = std::complex<double>(n[14], n[15]) * amperes;
    r.speed_el_rad_s = n[17] / Q16 * 2 * PI / (ticks * scales.period_s);
    r.torque = n[19] / Q15 * scales.voltage_v * scales.current_a / scales.speed_el_rad_s;
    return r;
}

std::vector<std::string> words_of(const std::string &line)
{
    std::istringstream stream(line);
    return {std::istream_iterator<std::string>(stream), {}};
}

} // namespace

std::vector<Record> Records::of(const std::string &kind) const
{
    std::vector<Record> found;
    std::copy_if(all.begin(), all.end(), std::back_inserter(found),
                 [&](const Record &record) { return record.kind == kind; });
    return found;
}

Records read_records(const std::vector<std::string> &lines, const std::string &name)
{
    Records records;
    for (std::size_t k = 0; k < lines.size(); k++) {
        const Place place = {name, k + 1};
        const std::vector<std::string> words = words_of(lines[k]);
        if (words.size() > 1 && words[0] == "identify" && words[1] == "1") {
            records = {};
            records.scales = scales_of(numbers_of(words, 1, SCALE_NUMBERS, place), place);
        } else if (words.size() > 1 && words[0] == "=") {
            if (records.scales.pole_pairs == 0) {
                place.refuse("a record without the line `identify 1 …` before it");
            }
            records.all.push_back(record_of(words[1], numbers_of(words, 2, RECORD_NUMBERS, place),
                                            records.scales, place));
            records.duration_s += records.all.back().ticks * records.scales.period_s;
        }
    }
    if (records.all.empty()) {
        throw ConfigError(fmt::format("{}: no record of an identification in it", name));
    }
    return records;
}

} // namespace nf::identify
