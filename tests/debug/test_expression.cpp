// SPDX-License-Identifier: MIT
// Expressions: value, precedence, names, and what is refused with which column.
#include "expression.h"
#include "vocabulary.h"

#include <string>

#include "testing.h"

using nf::Tick;
using nf::debug::ExpressionError;
using nf::debug::parse_expression;
using nf::debug::Value;

// x is 3, y.z[1] is −2; no other names.
static Value lookup(const std::string &name)
{
    if (name == "x") {
        return [](const Tick &) { return 3.0; };
    }
    if (name == "y.z[1]") {
        return [](const Tick &) { return -2.0; };
    }
    throw std::runtime_error("there is no " + name);
}

static void expect(double value, const char *text)
{
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value, parse_expression(text, lookup)(Tick{}), text);
}

TEST(test_values_and_precedence_are_those_of_c)
{
    expect(7, "1 + 2*x");
    expect(9, "(1+2) * x");
    expect(-5, "-x + y.z[1]");
    expect(5, "abs(-x + y.z[1])");
    expect(-1, "2 - 3");
    expect(-4, "2 - 3 - 3");
    expect(0.5, "x / 2 / 3");
    expect(1250, "1.25e3");
    expect(1, "x > 2 && y.z[1] < 0");
    expect(0, "x > 2 && y.z[1] > 0");
    expect(1, "0 || 1 && 1");
    expect(1, "1 || 0 && 0");
    expect(0, "!x");
    expect(1, "!(x == 4)");
    expect(1, "x != 4");
    expect(1, "x >= 3 && x <= 3 && x == 3");
    expect(1, "1 + 1 < x");
    expect(1, "x&&1");
}

// Not known in a recording: what the motor does.
TEST(test_what_is_not_known_is_neither_true_nor_the_same_as_anything)
{
    for (const char *text :
         {"0/0 == 1", "0/0 == 0/0", "!(0/0)", "0/0 && 1", "0/0 > 0", "0/0 <= 0"}) {
        expect(0, text);
    }
    expect(1, "0/0 != 1");
}

static void expect_refused(const char *text, const char *part)
{
    std::string message;
    try {
        (void)parse_expression(text, lookup);
    } catch (const ExpressionError &error) {
        message = error.what();
    }
    TEST_ASSERT_TRUE_MESSAGE(message.find(part) != std::string::npos,
                             ("'" + std::string(text) + "': " + message).c_str());
}

TEST(test_what_is_wrong_is_named_with_its_column)
{
    expect_refused("", "column 1 of '': a value is missing");
    expect_refused("x >", "column 4");
    expect_refused("x > speed", "column 5 of 'x > speed': there is no speed");
    expect_refused("(x", "column 3 of '(x': a ) is missing");
    expect_refused("x x", "column 3 of 'x x': 'x' is not expected here");
    expect_refused("1 < x < 5", "do not chain");
    expect_refused("x = 3", "'= 3' is not expected here");
    expect_refused("$", "'$' is neither a number nor a name");
    expect_refused("1e999", "this is no number");
    expect_refused(".", "this is no number");
    expect_refused(std::string(5000, '(').c_str(), "nested too deeply");
    expect_refused(std::string(5000, '-').c_str(), "nested too deeply");
}

TEST(test_states_and_faults_are_numbers)
{
    const Tick tick{};
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_STATE_RUN, nf::debug::named_value("RUN")(tick));
    TEST_ASSERT_EQUAL_DOUBLE(FAULT_OVERCURRENT, nf::debug::named_value("OVERCURRENT")(tick));
}

TEST(test_an_unknown_signal_lists_the_near_names)
{
    std::string message;
    try {
        (void)nf::debug::named_value("speed_estimted_rpm");
    } catch (const std::runtime_error &error) {
        message = error.what();
    }
    TEST_ASSERT_TRUE_MESSAGE(message.find("near: speed_estimated_rpm") != std::string::npos,
                             message.c_str());
}
