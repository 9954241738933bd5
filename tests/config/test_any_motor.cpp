// SPDX-License-Identifier: MIT
// Real motors, and every key at both ends of its range: what is not accepted is refused by a line
// that the user wrote.
#include "folder.h"

#include "draw.h"
#include "schema.h"
#include "zoo.h"

#include <fmt/format.h>

#include "testing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace
{

using Lines = std::vector<std::string>;

const char *const TUNINGS[] = {"published", "robust_motor_a", "any", "voltage_phase"};
const char *const SOURCES[] = {"observer", "sensor"};

// What the shipped board and the published tuning say of another motor.
const Lines OWN_BOARD = {"board.trip_a=0",
                         "speed_loop.bandwidth_hz=0",
                         "speed_loop.ramp_rpm_s=0",
                         "position_loop.bandwidth_hz=0",
                         "position_loop.speed_rpm=0",
                         "position_loop.acceleration_rad_s2=0",
                         "position_loop.softness_s=0"};

// The numbers of a file as KEY=VALUE.
void add_numbers(const std::string &file, Lines &lines)
{
    std::istringstream stream(file);
    std::string section;
    for (std::string line; std::getline(stream, line);) {
        const std::size_t equals = line.find(" = ");
        if (line.rfind('[', 0) == 0) {
            section = line.substr(1, line.find(']') - 1);
        } else if (equals != std::string::npos && std::isdigit(line[equals + 3]) != 0) {
            lines.push_back(
                fmt::format("{}.{}={}", section, line.substr(0, equals), line.substr(equals + 3)));
        }
    }
}

// A motor of the zoo and its board, as overrides of the shipped ones.
Lines any_motor(int number)
{
    const nf::zoo::Reference motor =
        nf::zoo::parse(fmt::format("zoo:{}", number)).value_or(nf::zoo::Reference());
    Lines lines;
    add_numbers(nf::zoo::motor_file(motor), lines);
    add_numbers(nf::zoo::board_file(motor), lines);
    return lines;
}

Lines real_motor(int number)
{
    Lines lines = any_motor(number);
    lines.insert(lines.end(), OWN_BOARD.begin(), OWN_BOARD.end());
    return lines;
}

// "" or the refusal.
std::string refusal_of(const std::string &tuning, const Lines &set)
{
    try {
        nf::build(nf::load_parts("motor_a", "bench_310v", tuning, {}, set));
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

std::string after(const std::string &text, const std::string &mark)
{
    const std::size_t at = text.find(mark);
    return at == std::string::npos ? "" : text.substr(at + mark.size());
}

// Line `number` of a file.
std::string line_of(const std::string &file, long number)
{
    std::ifstream stream(file);
    std::string line;
    for (long k = 0; k < number; k++) {
        std::getline(stream, line);
    }
    return line;
}

bool is_number(const std::string &text, double value)
{
    const double found = std::strtod(text.c_str(), nullptr);
    return std::abs(found - value) <= 1e-9 * std::abs(value);
}

// "PLACE: KEY = VALUE: ...": VALUE stands at that place for that key.
bool names_what_is_written(const std::string &refusal, const Lines &set)
{
    const std::string place = refusal.substr(0, refusal.find(": "));
    const std::string assignment = after(refusal, ": ");
    const std::string key = assignment.substr(0, assignment.find(" = "));
    const double value = std::strtod(after(assignment, " = ").c_str(), nullptr);
    if (place == "--set") {
        // The last of several wins.
        const auto line = std::find_if(set.rbegin(), set.rend(), [&](const std::string &any) {
            return any.rfind(key + "=", 0) == 0;
        });
        return line != set.rend() && is_number(after(*line, "="), value);
    }
    const std::size_t colon = place.rfind(':');
    const std::string line =
        line_of(place.substr(0, colon), std::strtol(place.substr(colon + 1).c_str(), nullptr, 10));
    return line.find(after(key, ".")) != std::string::npos && is_number(after(line, "= "), value);
}

// The key and the limit of "KEY = VALUE: …; allowed: at most LIMIT UNIT: …", or of "…; allowed:
// write KEY …, at most LIMIT UNIT: …".
struct Limit {
    std::string key;
    std::string text; // "LIMIT UNIT: …"; empty where none is said
};

Limit limit_of(const std::string &refusal)
{
    const std::string allowed = after(refusal, "; allowed: ");
    const std::string write = "write ";
    const std::string from =
        allowed.rfind(write, 0) == 0 ? after(allowed, write) : after(refusal, ": ");
    const std::size_t at = std::min(allowed.find("at most "), allowed.find("at least "));
    return at == std::string::npos
               ? Limit{}
               : Limit{from.substr(0, from.find(' ')), after(allowed.substr(at + 3), " ")};
}

// A number that the key may have, in its unit; and with it that key is no longer refused.
void expect_a_limit_that_helps(const std::string &refusal, const std::string &tuning, Lines set)
{
    for (const char *none : {" nan", "-nan", " inf", "-inf"}) {
        TEST_ASSERT_EQUAL_size_t_MESSAGE(std::string::npos, refusal.find(none), refusal.c_str());
    }
    const Limit limit = limit_of(refusal);
    if (limit.text.empty() && refusal.find("does not fit the firmware") == std::string::npos) {
        return; // the range of the key itself
    }
    if (limit.text.empty()) {
        TEST_ASSERT_NOT_EQUAL_size_t_MESSAGE(std::string::npos, refusal.find("; allowed: another "),
                                             refusal.c_str());
        return;
    }
    const nf::Field *field = nf::find_field(limit.key);
    TEST_ASSERT_NOT_NULL_MESSAGE(field, refusal.c_str());
    char *end = nullptr;
    const double value = std::strtod(limit.text.c_str(), &end);
    const std::string unit = *field->unit == '\0' ? "" : std::string(" ") + field->unit;
    TEST_ASSERT_TRUE_MESSAGE(value >= field->min && value <= field->max, refusal.c_str());
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(unit.c_str(), end, unit.size(), refusal.c_str());
    if (refusal.find(", which is ") != std::string::npos) {
        return; // the limit is what another line says, and that line may be wrong too
    }
    const std::string number = limit.text.substr(0, limit.text.find_first_of(" :"));
    set.push_back(fmt::format("{}={}", limit.key, number));
    const std::string again = refusal_of(tuning, set);
    const std::string itself =
        fmt::format("--set: {} = {}: does not fit the firmware; ", limit.key, number);
    const bool is_refused_again = again.rfind(itself, 0) == 0 || limit_of(again).key == limit.key;
    TEST_ASSERT_FALSE_MESSAGE(is_refused_again,
                              fmt::format("{}\n{}: {}", refusal, set.back(), again).c_str());
}

void expect_a_written_line(const std::string &tuning, const Lines &set)
{
    const std::string refusal = refusal_of(tuning, set);
    if (refusal.empty()) {
        return;
    }
    if (!names_what_is_written(refusal, set)) {
        TEST_FAIL_MESSAGE(refusal.c_str());
    }
    expect_a_limit_that_helps(refusal, tuning, set);
}

constexpr int MOTORS = 1000;

TEST(a_real_motor_is_accepted)
{
    for (int k = 0; k < MOTORS; k++) {
        Lines set = real_motor(k);
        set.push_back(fmt::format("drive.angle_source={}", SOURCES[k / 3 % 2]));
        TEST_ASSERT_EQUAL_STRING("", refusal_of(TUNINGS[k % 3], set).c_str());
    }
}

// All that the shipped board and tunings write stays: what does not go with it is refused by what
// the user wrote.
TEST(a_real_motor_is_never_refused_by_a_line_of_a_shipped_file)
{
    int refused = 0;
    for (int k = 0; k < MOTORS; k++) {
        const Lines motor = any_motor(k);
        const std::string refusal = refusal_of(TUNINGS[k % 3], motor);
        if (!refusal.empty()) {
            refused++;
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, refusal.rfind("--set: ", 0), refusal.c_str());
            expect_a_limit_that_helps(refusal, TUNINGS[k % 3], motor);
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(MOTORS / 50, refused);
}

// Beside the range of each key, from the schema, the values of combinations: not-so-real motors.
TEST(every_key_at_both_ends_is_accepted_or_refused_as_written)
{
    for (int round = 0; round < 3; round++) {
        const Lines motor = real_motor(round);
        for (const nf::Field &field : nf::schema()) {
            nf::Config any;
            const nf::Target target = field.target(any);
            const bool is_number =
                std::holds_alternative<double *>(target) || std::holds_alternative<int *>(target);
            if (!is_number || std::string(field.section) == "hal" ||
                std::string(field.section) == "scenario") {
                continue;
            }
            for (const double end : {field.min, field.max}) {
                Lines set = motor;
                set.push_back(fmt::format("drive.angle_source={}", SOURCES[round % 2]));
                set.push_back(fmt::format("{}={}", field.name(), end));
                expect_a_written_line(TUNINGS[round % 3], set);
            }
        }
    }
}

// Several keys at an end at once.
TEST(any_combination_of_ends_is_accepted_or_refused_as_written)
{
    std::vector<const nf::Field *> fields;
    for (const nf::Field &field : nf::schema()) {
        nf::Config any;
        const std::string section = field.section;
        if (std::holds_alternative<double *>(field.target(any)) && section != "hal" &&
            section != "scenario" && section != "plant") {
            fields.push_back(&field);
        }
    }
    for (int round = 0; round < 600; round++) {
        const nf::zoo::Draw draw(fmt::format("round {}", round));
        Lines set = real_motor(round);
        set.push_back(fmt::format("drive.angle_source={}", SOURCES[draw.below("source", 2)]));
        for (const char *one : {"first", "second", "third"}) {
            const nf::zoo::Draw of_key(fmt::format("round {}, {}", round, one));
            const nf::Field &field = *fields[of_key.below("field", fields.size())];
            const double end = of_key.below("end", 2) == 0 ? field.min : field.max;
            const double between = of_key.log_uniform(
                "between", {std::max(field.min, 1e-7), std::max(field.max, 1e-6)});
            const double value = of_key.below("an end", 2) == 0 ? end : between;
            set.push_back(
                fmt::format("{}={}", field.name(), std::clamp(value, field.min, field.max)));
        }
        expect_a_written_line(TUNINGS[draw.below("tuning", 3)], set);
    }
}

// Where the limit of one key leaves another nothing, or takes it below zero.
TEST(a_limit_that_leaves_another_key_nothing_is_blamed_itself)
{
    const Lines none = {"board.overcurrent_a=19.989"};
    expect_a_written_line("robust_motor_a", none);
    TEST_ASSERT_EQUAL_INT(
        0, refusal_of("robust_motor_a", none).rfind("--set: board.overcurrent_a = 19.989: ", 0));
    const Lines cold = {"motor=outrunner_24v", "board=b_g431b_esc1", "board.adc_bits=8",
                        "board.temperature_points_c=[-50,149,150]",
                        "board.temperature_points_pct=[0,1,100]"};
    expect_a_written_line("robust_motor_a", cold);
    TEST_ASSERT_NOT_EQUAL_size_t(std::string::npos,
                                 refusal_of("robust_motor_a", cold).find("b_g431b_esc1.toml:"));
}

// 1.25 times the highest speed is a power of two of the speed base's steps: just inside, on it,
// just outside.
TEST(a_highest_speed_on_a_step_of_the_speed_base_is_accepted)
{
    for (const double rpm : {1500 * (1 - 1e-9), 1500.0, 1500 * (1 + 1e-9)}) {
        const Lines set = {"motor=motor_b", "board.pwm_frequency_hz=16000",
                           fmt::format("motor.max_speed_rpm={:.12g}", rpm)};
        TEST_ASSERT_EQUAL_STRING("", refusal_of("robust_motor_a", set).c_str());
    }
}

} // namespace
