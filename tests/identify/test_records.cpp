// SPDX-License-Identifier: MIT
// The lines of a console as records, and all that is refused of them: by file, line, what was found
// and what is expected.
#include "config.h"
#include "log_file.h"
#include "records.h"

extern "C" {
#include "crc32.h"
#include "text.h"
}

#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using nf::identify::read_records;
using nf::identify::Records;

using Lines = std::vector<std::string>;

constexpr double ROUNDED = 1e-12; // of doubles
// 100 µs, 20 A, 400 V, 4 pole pairs, shift 2.
const std::string FIRST = "identify 2 100000000 20000000 400000000 4 2";
const std::string OLD = "identify 1 100000000 20000000 400000000 4 2"; // the same without checksums
// axis, current, speed, pulse along, across, quarter, ticks, and the twelve sums
const std::string STILL = "= still 1 8192 0 0 0 1 100 163840 -3276800 819200 0 819200 100 200 0 0 "
                          "0 0 0";

// As the firmware sends them: with checksums, and the end where it is one of them.
Lines sent(const Lines &lines)
{
    Lines found;
    uint32_t crc = CRC32_START;
    for (const std::string &line : lines) {
        crc = text_crc(crc, line.data(), static_cast<uint32_t>(line.size()));
        found.push_back(fmt::format("{} #{:08X}", line, ~crc));
    }
    return found;
}

const std::string LATER = "= still 2" + STILL.substr(9);
const std::string DONE = "identify done";
const Lines WHOLE = sent({FIRST, STILL, LATER, DONE});

std::string refusal_of(const Lines &lines)
{
    try {
        read_records(lines, "log");
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

void expect_refused(const char *why, const Lines &lines)
{
    TEST_ASSERT_EQUAL_STRING(why, refusal_of(lines).c_str());
}

// A record of which one number is another.
std::string with_number(std::size_t which, const std::string &number)
{
    std::string line = "= still";
    std::size_t at = STILL.find(' ', 2);
    for (std::size_t k = 0; k < 19; k++) {
        const std::size_t end = STILL.find(' ', at + 1);
        line += k == which ? ' ' + number : STILL.substr(at, end - at);
        at = end;
    }
    return line;
}

TEST(test_a_record_is_in_si_units)
{
    const Records records = read_records({"> identify", OLD, STILL}, "log");
    TEST_ASSERT_EQUAL_size_t(1, records.all.size());
    const nf::identify::Record &r = records.all.front();
    TEST_ASSERT_EQUAL_STRING("still", r.kind.c_str());
    TEST_ASSERT_EQUAL_INT(1, r.axis);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 10, r.current_a);        // a quarter of 40 A
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 20, r.voltage_v.real()); // 1638.4 of 32768 of 400 V
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, -400, r.voltage_v.imag());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 10, r.i_a.real());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 400, r.bus_v); // a quarter is summed
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 0.01, records.duration_s);
    TEST_ASSERT_EQUAL_INT(4, records.scales.pole_pairs);
}

TEST(test_carriage_returns_and_other_lines_are_skipped)
{
    const Records records =
        read_records({"", "hello = world", OLD + "\r", "the shaft turns", STILL + "\r"}, "log");
    TEST_ASSERT_EQUAL_size_t(1, records.all.size());
}

TEST(test_the_last_of_several_identifications_counts)
{
    const Lines twice = {OLD, STILL, "identify refused: phase a is open", OLD, STILL, STILL};
    TEST_ASSERT_EQUAL_size_t(2, read_records(twice, "log").all.size());
}

TEST(test_no_record_is_refused)
{
    expect_refused("log: no record of an identification in it", {});
    expect_refused("log: no record of an identification in it", {"hello", OLD});
}

TEST(test_what_the_drive_has_refused_is_said)
{
    expect_refused("log:3: identify refused: phase a is open",
                   {OLD, STILL, "identify refused: phase a is open\r"});
    // before the scales
    expect_refused("log:1: identify refused: the drive is not READY",
                   {"identify refused: the drive is not READY"});
}

TEST(test_another_version_is_refused_whatever_follows)
{
    expect_refused("log:1: records of version 3, this program reads versions 1 and 2",
                   {"identify 3 100000000", STILL});
    expect_refused("log:1: records of version 0, this program reads versions 1 and 2",
                   {"identify 0"});
    expect_refused("log:1: records of version 3, this program reads versions 1 and 2",
                   sent({"identify 3 100000000", STILL}));
}

TEST(test_a_record_before_the_scales_is_refused)
{
    expect_refused("log:1: a record without the line `identify 2 …` before it", {STILL});
}

TEST(test_a_line_with_too_few_or_too_many_numbers_is_refused)
{
    expect_refused("log:1: 4 numbers, expected 5: the line is not complete",
                   {"identify 1 100000000 20000000 400000000 4"});
    expect_refused("log:2: 20 numbers, expected 19: the line is not complete", {OLD, STILL + " 7"});
    expect_refused("log:2: 2 numbers, expected 19: the line is not complete",
                   {OLD, "= still 1 8192"});
}

TEST(test_what_is_no_whole_number_is_refused)
{
    expect_refused("log:2: \"8.5\" is not a whole number", {OLD, with_number(1, "8.5")});
    expect_refused("log:2: \"1e3\" is not a whole number", {OLD, with_number(1, "1e3")});
}

TEST(test_an_unknown_kind_is_refused)
{
    expect_refused("log:2: a record of the kind \"stil\", expected one of pulse, catch, still, "
                   "burst, spin, ramp, hold, coast, hall",
                   {OLD, "= stil" + STILL.substr(7)});
}

TEST(test_scales_beyond_their_range_are_refused)
{
    expect_refused("log:1: the tick in ps is 0, expected 1 to 2147483647",
                   {"identify 1 0 20000000 400000000 4 2"});
    expect_refused("log:1: the full scale of the current in µA is -1, expected 1 to 2147483647",
                   {"identify 1 100000000 -1 400000000 4 2"});
    expect_refused("log:1: the full scale of the bus in µV is 0, expected 1 to 2147483647",
                   {"identify 1 100000000 20000000 0 4 2"});
    expect_refused("log:1: the number of pole pairs is 1001, expected 1 to 1000",
                   {"identify 1 100000000 20000000 400000000 1001 2"});
    expect_refused("log:1: the shift of the speeds is 32, expected 0 to 31",
                   {"identify 1 100000000 20000000 400000000 4 32"});
    expect_refused("log:1: the shift of the speeds is -1, expected 0 to 31",
                   {"identify 1 100000000 20000000 400000000 4 -1"});
}

TEST(test_numbers_of_a_record_beyond_their_range_are_refused)
{
    expect_refused("log:2: the axis is 3, expected 0 to 2", {OLD, with_number(0, "3")});
    expect_refused("log:2: the quarter of the pulses in ticks is 65, expected 1 to 64",
                   {OLD, with_number(5, "65")});
    expect_refused("log:2: the quarter of the pulses in ticks is 0, expected 1 to 64",
                   {OLD, with_number(5, "0")});
    expect_refused("log:2: the window in ticks is 131072, expected 1 to 131071",
                   {OLD, with_number(6, "131072")});
    expect_refused("log:2: the window in ticks is 0, expected 1 to 131071",
                   {OLD, with_number(6, "0")});
}

// ---- checksums ----

TEST(test_records_with_checksums_are_read_without_a_remark)
{
    const Records records = read_records(WHOLE, "log");
    TEST_ASSERT_EQUAL_size_t(2, records.all.size());
    TEST_ASSERT_EQUAL_INT(2, records.all.back().axis);
    TEST_ASSERT_EQUAL_STRING("", records.remark.c_str());
}

TEST(test_records_of_an_older_firmware_are_read_with_a_remark)
{
    TEST_ASSERT_EQUAL_STRING("The records have no checksums, as of an older firmware: a digit that "
                             "was changed does not show.",
                             read_records({OLD, STILL, STILL}, "log").remark.c_str());
}

// Each digit of each line, the version and the checksum too, made another digit of either kind.
TEST(test_any_changed_digit_is_refused_with_the_name_of_its_line)
{
    for (std::size_t k = 0; k < WHOLE.size(); k++) {
        for (std::size_t at = 0; at < WHOLE[k].size(); at++) {
            if (std::string("0123456789ABCDEF").find(WHOLE[k][at]) == std::string::npos) {
                continue;
            }
            Lines lines = WHOLE;
            lines[k][at] = lines[k][at] == '7' ? '3' : '7';
            const std::string head = fmt::format("log:{}: the record's checksum is ", k + 1);
            TEST_ASSERT_EQUAL_STRING_LEN(head.c_str(), refusal_of(lines).c_str(), head.size());
        }
    }
}

TEST(test_a_line_that_is_missing_exchanged_or_cut_is_refused)
{
    const auto without = [](std::size_t which) {
        Lines lines = WHOLE;
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(which));
        return lines;
    };
    expect_refused("log:1: a record without the line `identify 2 …` before it", without(0));
    const std::string missing = refusal_of(without(1));
    TEST_ASSERT_EQUAL_STRING_LEN("log:2: the record's checksum", missing.c_str(), 28);
    TEST_ASSERT_EQUAL_STRING_LEN("log:3: the record's checksum", refusal_of(without(2)).c_str(),
                                 28);
    expect_refused("log: it ends after 2 records, without the line `identify done`: the log is cut "
                   "off",
                   without(3));
    Lines exchanged = WHOLE;
    std::swap(exchanged[1], exchanged[2]);
    TEST_ASSERT_EQUAL_STRING_LEN("log:2: the record's checksum", refusal_of(exchanged).c_str(), 28);
    Lines cut = WHOLE;
    cut[2].resize(cut[2].size() - 3);
    expect_refused("log:3: the record has no checksum: the line is not complete", cut);
}

// ---- what terminal programs make of the lines ----

TEST(test_what_a_logger_puts_in_front_does_not_matter)
{
    for (const char *const stamp :
         {"[12:00:01.500] ", "12:00:01.500 -> ", "2026-11-28T12:00:00Z|", "\xEF\xBB\xBF", "< ",
          "port = COM3 ", "\r", "\t", "rx: identify ", "\033[32m"}) {
        Lines lines = {"hello", "the shaft turns"};
        lines.insert(lines.begin() + 1, WHOLE.begin(), WHOLE.end());
        for (std::string &line : lines) {
            line.insert(0, stamp);
        }
        TEST_ASSERT_EQUAL_size_t_MESSAGE(2, read_records(lines, "log").all.size(), stamp);
        const Lines old = {stamp + OLD, stamp + STILL, stamp + LATER};
        TEST_ASSERT_EQUAL_size_t_MESSAGE(2, read_records(old, "log").all.size(), stamp);
        expect_refused("log:2: identify refused: phase a is open",
                       {"x", stamp + std::string("identify refused: phase a is open\r")});
    }
}

TEST(test_a_log_that_has_each_line_twice_is_read_once)
{
    for (const Lines &once : {WHOLE, Lines{OLD, STILL, LATER}}) {
        Lines twice;
        for (const std::string &line : once) {
            twice.insert(twice.end(), {"[1] " + line, "[2] " + line});
        }
        TEST_ASSERT_EQUAL_size_t(2, read_records(twice, "log").all.size());
    }
}

TEST(test_text_with_an_equals_sign_is_no_record)
{
    Lines lines = WHOLE;
    lines.insert(lines.begin() + 2, {"speed = 5", "[12] x = y z", "identify by hand"});
    TEST_ASSERT_EQUAL_size_t(2, read_records(lines, "log").all.size());
}

// 100 ticks: eleven numbers more, of which the last two of each three are of 32768 and of ticks.
TEST(test_a_record_of_hall_has_the_survey_of_three_signals)
{
    const std::string numbers = STILL.substr(STILL.find(" 1 8192"));
    const std::string survey = " 16384 -131072 3276800 0 50 0 -1638400 100 0 0 0";
    const Records records = read_records(sent({FIRST, "= hall" + numbers + survey, DONE}), "log");
    const nf::identify::Record &hall = records.all.front();
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 0.25, hall.start_turns);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, -2, hall.turns_el);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 1, hall.halls[0].middle.real());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 0.5, hall.halls[0].high);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, -0.5, hall.halls[1].middle.imag());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 1, hall.halls[1].high);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 0, hall.halls[2].high);
    expect_refused("log:2: 19 numbers, expected 30: the line is not complete",
                   sent({FIRST, "= hall" + numbers, DONE}));
}

} // namespace
