// SPDX-License-Identifier: MIT
// Made-up signals: what goes with the rotor's angle is ripple, what has a frequency of its own is
// left.
#include "ripple.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

#include "testing.h"

namespace
{

constexpr double PI = 3.14159265358979323846;
constexpr std::size_t TICKS = 4000;
constexpr double TURNS = 3.3; // electrical, in all ticks
constexpr double ROUNDING = 1e-9;
// Sampled 4000/3.3/12 times in a period of the highest order, a top is missed by 1 − cos(π/101).
constexpr double TOP = 0.0005;

using Signal = std::function<double(double)>; // of the share of all ticks that has gone

double angle_at(double share, double turns)
{
    return 2 * PI * turns * share;
}

// The rotor turns faster and slower meanwhile, as a ripple makes it do.
double uneven(double share, double turns)
{
    return angle_at(share, turns) + 0.1 * std::sin(angle_at(share, 2 * turns));
}

void add_to(nf::Ripple &ripple, double angle_el_rad, double value)
{
    ripple.add(angle_el_rad, {value, -3 * value});
}

// Of the first signal. The second is −3 times the first, and so is what is left of it.
nf::Ripple::Split split_of(const nf::Ripple &ripple, std::size_t settled)
{
    const auto [first, second] = ripple.split(settled);
    TEST_ASSERT_EQUAL_size_t(first.rest.size(), second.rest.size());
    for (std::size_t k = 0; k < first.rest.size(); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -3 * first.rest[k], second.rest[k]);
    }
    TEST_ASSERT_EQUAL(first.amplitude.has_value(), second.amplitude.has_value());
    if (first.amplitude) {
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 3 * *first.amplitude, *second.amplitude);
    }
    return first;
}

nf::Ripple::Split split_of(const Signal &signal, double turns = TURNS, std::size_t settled = 0)
{
    nf::Ripple ripple;
    for (std::size_t k = 0; k < TICKS; k++) {
        const double share = static_cast<double>(k) / TICKS;
        const double wrapped = std::remainder(uneven(share, turns), 2 * PI);
        add_to(ripple, wrapped, signal(share));
    }
    return split_of(ripple, settled);
}

void check_amplitude(double share, double expected, const nf::Ripple::Split &found)
{
    TEST_ASSERT_TRUE(found.amplitude.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(share * expected, expected, *found.amplitude);
}

double height(const std::vector<double> &values)
{
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *high - *low;
}

TEST(test_what_repeats_with_the_angle_is_ripple)
{
    for (const int order : {1, 2, 6, 12}) {
        const auto split = split_of([order](double share) {
            return 100 + 3 * std::sin(order * uneven(share, TURNS) + 0.7);
        });
        check_amplitude(TOP, 3, split);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, height(split.rest));
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 100, split.rest.front());
    }
}

TEST(test_so_is_it_backwards_and_on_a_signal_that_settles)
{
    const auto settles = [](double share) { return 100 + 5 * share - 4 * share * share; };
    const auto split = split_of(
        [&](double share) { return settles(share) + std::cos(6 * uneven(share, -TURNS)); }, -TURNS);
    check_amplitude(TOP, 1, split);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, settles(0.5), split.rest[TICKS / 2]);
}

// Orders 3.6 and 9 lie 5 and 10 periods in all from the nearest order of the rotor: what of them
// leaks into it goes with the inverse of these.
TEST(test_a_swing_of_its_own_frequency_is_left)
{
    constexpr double LEAK = 1 / (PI * 0.4 * TURNS);
    for (const double order : {3.6, 9.0}) {
        const auto split = split_of(
            [order](double share) { return 3 * std::sin(order * angle_at(share, TURNS)); });
        TEST_ASSERT_DOUBLE_WITHIN(2 * LEAK * 6, 6, height(split.rest));
    }
}

TEST(test_beside_a_ripple_a_swing_of_its_own_is_left)
{
    constexpr double TURNS_LONG = 20;
    const auto split = split_of(
        [](double share) {
            return 2 * std::sin(6 * uneven(share, TURNS_LONG)) +
                   3 * std::sin(9 * angle_at(share, TURNS_LONG));
        },
        TURNS_LONG);
    // Of the swing, and of what the uneven turn makes of it an order from the rotor's: 20 periods
    // apart.
    constexpr double LEAK = 3 / (PI * TURNS_LONG);
    TEST_ASSERT_TRUE(split.amplitude.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(2 * LEAK, 2, *split.amplitude);
    TEST_ASSERT_DOUBLE_WITHIN(4 * LEAK, 6, height(split.rest));
}

TEST(test_less_than_two_turns_tell_nothing_apart)
{
    const auto ripple = [](double turns) {
        return [turns](double share) { return std::sin(6 * uneven(share, turns)); };
    };
    const auto less = split_of(ripple(1.99), 1.99);
    TEST_ASSERT_FALSE(less.amplitude.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(2 * TOP, 2, height(less.rest));
    check_amplitude(TOP, 1, split_of(ripple(2.05), 2.05));
}

// With 18 samples in a turn order 12 looks like order 6: it is left out, and the samples from
// another speed keep what they are.
TEST(test_an_order_that_the_samples_do_not_show_adds_nothing)
{
    nf::Ripple ripple;
    const auto signal = [](double angle) { return 2 * std::sin(6 * angle); };
    double angle = 0;
    for (int k = 0; k < 400; k++) {
        angle += 2 * PI / (k < 100 ? 50 : 18);
        add_to(ripple, std::remainder(angle, 2 * PI), signal(angle));
    }
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, height(split_of(ripple, 100).rest));
}

// A jump at its beginning turns no ripple up, and is left.
TEST(test_only_the_settled_part_is_fitted)
{
    constexpr std::size_t BEGINNING = TICKS / 5;
    const auto split = split_of(
        [](double share) {
            const double jump = share < 0.2 ? 50 * (0.2 - share) : 0;
            return jump + std::sin(2 * uneven(share, TURNS));
        },
        TURNS, BEGINNING);
    check_amplitude(TOP, 1, split);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 10, split.rest.front());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, split.rest.back());
}

TEST(test_nothing_and_what_has_not_settled_is_left_as_it_is)
{
    nf::Ripple ripple;
    TEST_ASSERT_EQUAL_size_t(0, split_of(ripple, 0).rest.size());
    add_to(ripple, 1, 7);
    TEST_ASSERT_EQUAL_DOUBLE(7, split_of(ripple, 5).rest.front());
    ripple.clear();
    TEST_ASSERT_EQUAL_size_t(0, split_of(ripple, 0).rest.size());
}

// One fit to a rotor that gives way, rests and accelerates again would find ripple in the change of
// its speed.
TEST(test_a_rotor_that_rests_meanwhile_has_the_ripple_of_its_steady_stretches)
{
    constexpr double STEADY = 0.01; // rad a tick
    nf::Ripple ripple;
    std::vector<double> speeds;
    double angle = 0;
    for (int k = 0; k < 12000; k++) {
        const double gives_way = std::max(0.0, 1 - (k - 4000) / 500.0);
        const double comes_back = std::min(1.0, (k - 8000) / 500.0);
        const double share = k < 4000 ? 1 : k < 8000 ? gives_way : comes_back;
        angle += STEADY * share;
        const double speed = 1000 * share + 5 * share * std::sin(6 * angle);
        speeds.push_back(speed);
        add_to(ripple, std::remainder(angle, 2 * PI), speed);
    }
    const auto split = split_of(ripple, 0);
    check_amplitude(0.02, 5, split); // of it a stretch at the edges may have lost 2 %
    for (std::size_t k = 0; k < speeds.size(); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(5.1, speeds[k], split.rest[k]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 1000, split.rest[2000]);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 1000, split.rest[11000]);
}

// It counts as no ripple of the rotor.
TEST(test_what_goes_with_the_supply_is_taken_off_too)
{
    nf::Ripple ripple;
    for (std::size_t k = 0; k < TICKS; k++) {
        const double share = static_cast<double>(k) / TICKS;
        const double supply = angle_at(share, 8.3);
        const double value = 100 + 7 * std::sin(supply + 1);
        ripple.add(angle_at(share, TURNS), {value, -3 * value}, std::remainder(supply, 2 * PI));
    }
    const auto split = split_of(ripple, 0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, height(split.rest));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, split.amplitude.value_or(1));
}

} // namespace
