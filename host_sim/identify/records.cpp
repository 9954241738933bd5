// SPDX-License-Identifier: MIT
#include "records.h"

#include "config.h"
#include "log_file.h"
#include "readable.h"
#include "si.h"

extern "C" {
#include "crc32.h"
#include "text.h"
}

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::identify
{
namespace
{

constexpr double Q15 = 32768;
constexpr double Q16 = 65536;
constexpr double STEPS = 4294967296; // of a turn
constexpr long VERSION = 2;          // of the records, firmware/app/identify.h
constexpr long UNCHECKED = 1;        // the one before it, without checksums and end
constexpr std::size_t SCALE_NUMBERS = 5;
constexpr std::size_t RECORD_NUMBERS = 19;
constexpr std::size_t HALL_NUMBERS = 3;                      // of each signal
constexpr std::size_t SURVEY_NUMBERS = 2 + 3 * HALL_NUMBERS; // more of a record of hall
const char *const KINDS[] = {"pulse", "catch", "still", "burst", "spin",
                             "ramp",  "hold",  "coast", "hall"};

// What the firmware can have sent: the ranges of the words of probe.h and of a shift; and no motor
// has more pole pairs.
struct Range {
    const char *what;
    double least;
    double most;
};
constexpr double WORD_MOST = 2147483647;
constexpr Range TICK_PS = {"the tick in ps", 1, WORD_MOST};
constexpr Range CURRENT_UA = {"the full scale of the current in µA", 1, WORD_MOST};
constexpr Range BUS_UV = {"the full scale of the bus in µV", 1, WORD_MOST};
constexpr Range POLE_PAIRS = {"the number of pole pairs", 1, 1000};
constexpr Range SPEED_SHIFT = {"the shift of the speeds", 0, 31};
constexpr Range AXIS = {"the axis", 0, 2};
constexpr Range QUARTER = {"the quarter of the pulses in ticks", 1, 64};
constexpr Range TICKS = {"the window in ticks", 1, 131071};

struct Place {
    const std::string &name;
    std::size_t line;

    [[noreturn]] void refuse(const std::string &what) const
    {
        throw ConfigError(fmt::format("{}:{}: {}", name, line, what));
    }
};

void check_range(double found, const Range &range, const Place &place)
{
    if (found < range.least || found > range.most) {
        place.refuse(fmt::format("{} is {:.0f}, expected {:.0f} to {:.0f}", range.what, found,
                                 range.least, range.most));
    }
}

// Nothing where the word is no whole number.
std::optional<long> whole_of(const std::string &word)
{
    long value = 0;
    const char *const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    return error == std::errc() && stop == end ? std::optional<long>(value) : std::nullopt;
}

// The words behind the first two as whole numbers.
std::vector<double> numbers_of(const std::vector<std::string> &words, std::size_t count,
                               const Place &place)
{
    constexpr std::size_t first = 2;
    if (words.size() != first + count) {
        place.refuse(fmt::format("{} numbers, expected {}: the line is not complete",
                                 words.size() - first, count));
    }
    std::vector<double> numbers;
    for (std::size_t k = first; k < words.size(); k++) {
        const std::optional<long> value = whole_of(words[k]);
        if (!value) {
            place.refuse(fmt::format("\"{}\" is not a whole number", readable(words[k])));
        }
        numbers.push_back(static_cast<double>(*value));
    }
    return numbers;
}

// Other versions may have other numbers behind theirs: it is looked at before them.
void check_version(long version, const Place &place)
{
    if (version != VERSION && version != UNCHECKED) {
        place.refuse(fmt::format("records of version {}, this program reads versions {} and {}",
                                 version, UNCHECKED, VERSION));
    }
}

Scales scales_of(const std::vector<double> &n, const Place &place)
{
    constexpr double pico = 1e-12;
    constexpr double micro = 1e-6;
    check_range(n[0], TICK_PS, place);
    check_range(n[1], CURRENT_UA, place);
    check_range(n[2], BUS_UV, place);
    check_range(n[3], POLE_PAIRS, place);
    check_range(n[4], SPEED_SHIFT, place);
    Scales scales;
    scales.period_s = n[0] * pico;
    scales.current_a = 2 * n[1] * micro;
    scales.voltage_v = n[2] * micro;
    scales.pole_pairs = static_cast<int>(n[3]);
    scales.speed_el_rad_s = Q15 * std::exp2(n[4]) * 2 * PI / STEPS / scales.period_s;
    return scales;
}

bool is_kind(const std::string &kind)
{
    return std::find(std::begin(KINDS), std::end(KINDS), kind) != std::end(KINDS);
}

void check_kind(const std::string &kind, const Place &place)
{
    if (!is_kind(kind)) {
        place.refuse(fmt::format("a record of the kind \"{}\", expected one of {}", readable(kind),
                                 fmt::join(KINDS, ", ")));
    }
}

void take_survey(const std::vector<double> &n, Record &r)
{
    std::size_t at = RECORD_NUMBERS;
    r.start_turns = n[at++] / Q16;
    r.turns_el = n[at++] / Q16;
    for (HallLevels &hall : r.halls) {
        hall.middle = std::complex<double>(n[at], n[at + 1]) / Q15 / r.ticks;
        hall.high = n[at + 2] / r.ticks;
        at += HALL_NUMBERS;
    }
}

Record record_of(const std::string &kind, const std::vector<double> &n, const Scales &scales,
                 const Place &place)
{
    check_kind(kind, place);
    check_range(n[0], AXIS, place);
    check_range(n[5], QUARTER, place);
    check_range(n[6], TICKS, place);
    const double ticks = n[6];
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
    r.speed_el_rad_s = n[16] / Q16 * 2 * PI / (ticks * scales.period_s);
    r.torque = n[18] / Q15 * scales.voltage_v * scales.current_a / scales.speed_el_rad_s;
    if (n.size() > RECORD_NUMBERS) {
        take_survey(n, r);
    }
    return r;
}

std::size_t numbers_of_kind(const std::string &kind)
{
    return RECORD_NUMBERS + (kind == "hall" ? SURVEY_NUMBERS : 0);
}

std::vector<std::string> words_of(const std::string &line)
{
    std::istringstream stream(line);
    return {std::istream_iterator<std::string>(stream), {}};
}

// What of a line the firmware may have sent as a record: from its mark on, and its checksum.
struct Part {
    std::string text; // without the checksum
    std::optional<uint32_t> crc;
    bool first; // nothing is in front of it

    bool operator==(const Part &other) const
    {
        return text == other.text && crc == other.crc;
    }
};

// ` #` and eight digits at the end.
std::optional<uint32_t> take_checksum(std::string &text)
{
    constexpr std::string_view MARK = " #";
    constexpr std::size_t DIGITS = 8;
    constexpr int BASE = 16;
    const std::size_t at = text.rfind(MARK);
    if (at == std::string::npos || text.size() - at != MARK.size() + DIGITS) {
        return std::nullopt;
    }
    uint32_t value = 0;
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(end - DIGITS, end, value, BASE);
    if (error != std::errc() || stop != end) {
        return std::nullopt;
    }
    text.resize(at);
    return value;
}

// A logger may put anything in front, so the part begins at the last mark. Nothing where there is
// none.
std::optional<Part> part_of(const std::string &line)
{
    std::size_t from = std::string::npos;
    for (const char *const mark : {"= ", "identify "}) {
        const std::size_t at = line.rfind(mark);
        const bool later = from == std::string::npos || at > from;
        from = at != std::string::npos && later ? at : from;
    }
    if (from == std::string::npos) {
        return std::nullopt;
    }
    Part part = {line.substr(from, line.find_last_not_of(" \t\r") + 1 - from), {}, from == 0};
    part.crc = take_checksum(part.text);
    return part;
}

// The line of its cause, and where it stands. Nothing: it was not refused.
struct Refusal {
    std::size_t line = 0;
    std::string text;
};

// Line by line. A new first line begins anew: a log may have several identifications, the last one
// counts.
class Reader
{
public:
    void take(const std::string &line, const Place &place)
    {
        constexpr std::string_view BY_DRIVE = "identify refused: ";
        const std::size_t refused = line.find(BY_DRIVE);
        const std::optional<Part> part = part_of(line);
        if (refused != std::string::npos) {
            refusal_ = {place.line,
                        line.substr(refused, line.find_last_not_of(" \t\r") + 1 - refused)};
        } else if (part && !is_twice(*part)) {
            take_part(*part, words_of(part->text), place);
        }
    }

    Records end(const std::string &name) const
    {
        if (!refusal_.text.empty()) {
            Place{name, refusal_.line}.refuse(refusal_.text);
        }
        if (records_.all.empty()) {
            throw ConfigError(fmt::format("{}: no record of an identification in it", name));
        }
        if (version_ == VERSION && !ended_) {
            throw ConfigError(fmt::format(
                "{}: it ends after {} records, without the line `identify done`: the log is cut off",
                name, records_.all.size()));
        }
        return records_;
    }

private:
    void take_part(const Part &part, const std::vector<std::string> &words, const Place &place)
    {
        if (words.size() < 2) {
            return;
        }
        const bool identify = words[0] == "identify";
        const std::optional<long> version = whole_of(words[1]);
        if (identify && version) {
            begin(*version, part, words, place);
        } else if (identify && words[1] == "done") {
            check(part, place);
            ended_ = true;
        } else if (words[0] == "=" && (part.first || part.crc || is_kind(words[1]))) {
            add(part, words, place);
        }
        last_ = part;
    }

    // A log that has each line twice. Without checksums the first line says it, which no
    // identification sends twice: two records may be alike.
    bool is_twice(const Part &part)
    {
        const bool alike = last_ && *last_ == part;
        doubled_ = doubled_ || (alike && part.text.rfind("identify ", 0) == 0);
        return alike && (part.crc || doubled_);
    }

    // The checksum is also that of all records before this one.
    void check(const Part &part, const Place &place)
    {
        if (version_ == UNCHECKED) {
            return;
        }
        crc_ = text_crc(crc_, part.text.data(), static_cast<uint32_t>(part.text.size()));
        if (!part.crc) {
            place.refuse("the record has no checksum: the line is not complete");
        }
        if (*part.crc != ~crc_) {
            place.refuse(fmt::format(
                "the record's checksum is {:08X}, its characters with the records before it make "
                "{:08X}: it was changed, or one before it is missing",
                *part.crc, ~crc_));
        }
    }

    void begin(long version, const Part &part, const std::vector<std::string> &words,
               const Place &place)
    {
        const bool unchecked = version == UNCHECKED && !part.crc;
        version_ = unchecked ? UNCHECKED : VERSION;
        crc_ = CRC32_START;
        ended_ = false;
        if (!part.crc) { // of a changed digit the checksum tells more
            check_version(version, place);
        }
        check(part, place);
        check_version(version, place);
        records_ = {};
        refusal_ = {};
        records_.remark = unchecked ? "The records have no checksums, as of an older firmware: a "
                                      "digit that was changed does not show."
                                    : "";
        records_.scales = scales_of(numbers_of(words, SCALE_NUMBERS, place), place);
    }

    void add(const Part &part, const std::vector<std::string> &words, const Place &place)
    {
        if (records_.scales.pole_pairs == 0) {
            place.refuse(
                fmt::format("a record without the line `identify {} …` before it", VERSION));
        }
        check(part, place);
        records_.all.push_back(record_of(
            words[1], numbers_of(words, numbers_of_kind(words[1]), place), records_.scales, place));
        records_.duration_s += records_.all.back().ticks * records_.scales.period_s;
    }

    Records records_;
    Refusal refusal_;
    long version_ = VERSION;
    uint32_t crc_ = CRC32_START; // of all records so far
    bool ended_ = false;
    bool doubled_ = false;
    std::optional<Part> last_;
};

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
    Reader reader;
    for (std::size_t k = 0; k < lines.size(); k++) {
        reader.take(lines[k], {name, k + 1});
    }
    return reader.end(name);
}

Records read_records_file(const std::string &path)
{
    return read_records(log_lines(read_log(path, "keep the lines of one identification")), path);
}

} // namespace nf::identify
