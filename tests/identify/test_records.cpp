// SPDX-License-Identifier: MIT
// The lines of a console as records, and all that is refused of them: by file, line, what was found and what is expected.
#include "config.h"
#include "records.h"

#include <string>
#include <vector>

#include "testing.h"

namespace
{

using nf::identify::read_records;
using nf::identify::Records;

using Lines = std::vector<std::string>;

constexpr double ROUNDED = 1e-12; // of doubles
// 100 µs, 20 A, 400 V, 4 pole pairs, shift 2.
const std::string FIRST = "identify 1 100000000 20000000 400000000 4 2";
// axis, current, speed, pulse along, across, quarter, ticks, and the twelve sums
const std::string STILL = "= still 1 8192 0 0 0 1 100 163840 -3276800 819200 0 819200 100 200 0 0 "
                          "0 0 0";

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
    const Records records = read_records({"> identify", FIRST, STILL}, "log");
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
        read_records({"", "hello = world", FIRST + "\r", "the shaft turns", STILL + "\r"}, "log");
    TEST_ASSERT_EQUAL_size_t(1, records.all.size());
}

TEST(test_the_last_of_several_identifications_counts)
{
    const Lines twice = {FIRST, STILL, "identify refused: phase a is open", FIRST, STILL, STILL};
    TEST_ASSERT_EQUAL_size_t(2, read_records(twice, "log").all.size());
}

TEST(test_no_record_is_refused)
{
    expect_refused("log: no record of an identification in it", {});
    expect_refused("log: no record of an identification in it", {"hello", FIRST});
}

TEST(test_what_the_drive_has_refused_is_said)
{
    expect_refused("log:3: identify refused: phase a is open",
                   {FIRST, STILL, "identify refused: phase a is open\r"});
    // before the scales
    expect_refused("log:1: identify refused: the drive is not READY",
                   {"identify refused: the drive is not READY"});
}

TEST(test_another_version_is_refused_whatever_follows)
{
    expect_refused("log:1: records of version 2, this program reads version 1",
                   {"identify 2 100000000", STILL});
    expect_refused("log:1: records of version 0, this program reads version 1", {"identify 0"});
}

TEST(test_a_record_before_the_scales_is_refused)
{
    expect_refused("log:1: a record without the line `identify 1 …` before it", {STILL});
}

TEST(test_a_line_with_too_few_or_too_many_numbers_is_refused)
{
    expect_refused("log:1: 4 numbers, expected 5: the line is not complete",
                   {"identify 1 100000000 20000000 400000000 4"});
    expect_refused("log:2: 20 numbers, expected 19: the line is not complete",
                   {FIRST, STILL + " 7"});
    expect_refused("log:2: 2 numbers, expected 19: the line is not complete",
                   {FIRST, "= still 1 8192"});
}

TEST(test_what_is_no_whole_number_is_refused)
{
    expect_refused("log:2: \"8.5\" is not a whole number", {FIRST, with_number(1, "8.5")});
    expect_refused("log:2: \"1e3\" is not a whole number", {FIRST, with_number(1, "1e3")});
}

TEST(test_an_unknown_kind_is_refused)
{
    expect_refused("log:2: a record of the kind \"stil\", expected one of pulse, catch, still, "
                   "burst, spin, ramp, hold, coast",
                   {FIRST, "= stil" + STILL.substr(7)});
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
    expect_refused("log:2: the axis is 3, expected 0 to 2", {FIRST, with_number(0, "3")});
    expect_refused("log:2: the quarter of the pulses in ticks is 65, expected 1 to 64",
                   {FIRST, with_number(5, "65")});
    expect_refused("log:2: the quarter of the pulses in ticks is 0, expected 1 to 64",
                   {FIRST, with_number(5, "0")});
    expect_refused("log:2: the window in ticks is 131072, expected 1 to 131071",
                   {FIRST, with_number(6, "131072")});
    expect_refused("log:2: the window in ticks is 0, expected 1 to 131071",
                   {FIRST, with_number(6, "0")});
}

} // namespace
