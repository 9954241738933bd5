// SPDX-License-Identifier: MIT
// Sustained swings on made-up signals: what is one, what is none, and its amplitude and frequency.
#include "swing.h"

#include <cmath>
#include <functional>

#include "testing.h"

namespace
{

constexpr double PI = 3.14159265358979323846;
constexpr double PERIOD_S = 1e-3;
constexpr double HZ = 10;
constexpr double LEAST = 2; // an amplitude of 1
constexpr int SECOND = 1000;
// Half a sample from its top a sine of 100 samples a period has fallen by 1 − cos(π/100).
constexpr double TOP = 0.0005;
// Three periods between samples: a sample at either end.
constexpr double ENDS = 2 / 300.0;

using Signal = std::function<double(double)>; // of time

std::optional<nf::Swing> found_in(const Signal &signal, int ticks = SECOND)
{
    nf::SwingFinder finder(LEAST, PERIOD_S);
    for (int k = 0; k < ticks; k++) {
        finder.add(signal(k * PERIOD_S));
    }
    return finder.largest();
}

double sine(double time_s)
{
    return std::sin(2 * PI * HZ * time_s);
}

void check(double amplitude, double hz, const std::optional<nf::Swing> &found)
{
    TEST_ASSERT_TRUE(found.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(TOP * amplitude, amplitude, found->amplitude);
    TEST_ASSERT_DOUBLE_WITHIN(ENDS * hz, hz, found->hz);
}

// exp(−2πζf·t), whose logarithmic decrement over three periods is 6πζ/√(1−ζ²).
Signal damped(double zeta)
{
    return [zeta](double t) {
        return 50 * std::exp(-2 * PI * HZ * zeta / std::sqrt(1 - zeta * zeta) * t) * sine(t);
    };
}

TEST(test_a_swing_has_its_amplitude_and_frequency)
{
    check(3, HZ, found_in([](double t) { return 100 + 3 * sine(t); }));
}

TEST(test_what_stays_below_the_least_is_none)
{
    TEST_ASSERT_TRUE(found_in([](double t) { return 1.01 * sine(t); }).has_value());
    TEST_ASSERT_FALSE(found_in([](double t) { return 0.99 * sine(t); }).has_value());
}

// ln 2 = 6πζ/√(1−ζ²) at ζ = 0.0367.
TEST(test_a_swing_that_is_damped_dies_out)
{
    TEST_ASSERT_TRUE(found_in(damped(0.0360)).has_value());
    TEST_ASSERT_FALSE(found_in(damped(0.0375)).has_value());
    TEST_ASSERT_TRUE(found_in(damped(-0.02)).has_value());
}

TEST(test_three_periods_are_needed_after_the_first_half_swing)
{
    const auto swing = [](double t) { return 3 * std::cos(2 * PI * HZ * t); };
    // From the first turning point after the start, at half a period, seven half-swings; and the
    // way back that shows the last one's end, which takes acos(1/3)/2π of a period.
    const int last =
        static_cast<int>(std::ceil((4 + std::acos(1 / 3.0) / (2 * PI)) / HZ / PERIOD_S));
    TEST_ASSERT_FALSE(found_in(swing, last - 1).has_value());
    TEST_ASSERT_TRUE(found_in(swing, last + 1).has_value());
}

TEST(test_steps_ramps_and_noise_are_none)
{
    TEST_ASSERT_FALSE(found_in([](double t) { return t < 0.5 ? 0.0 : 1000.0; }).has_value());
    TEST_ASSERT_FALSE(found_in([](double t) { return 1e4 * t + 0.9 * sine(t); }).has_value());
    TEST_ASSERT_FALSE(
        found_in([](double t) { return std::remainder(t / PERIOD_S * 0.618, 1.9); }).has_value());
}

// It neither hides a swing nor makes one more of it: the extremes are off by no more than the
// noise.
TEST(test_noise_on_a_swing_changes_it_by_no_more_than_the_noise)
{
    constexpr double noise = 0.5;
    const auto found = found_in(
        [](double t) { return 5 * sine(t) + std::remainder(t / PERIOD_S * 0.618, 2 * noise); });
    TEST_ASSERT_TRUE(found.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(noise, 5, found->amplitude);
}

TEST(test_new_conditions_begin_anew)
{
    nf::SwingFinder finder(LEAST, PERIOD_S);
    for (int k = 0; k < SECOND; k++) {
        if (k % 300 == 0) { // three periods
            finder.restart();
        }
        finder.add(3 * sine(k * PERIOD_S));
    }
    TEST_ASSERT_FALSE(finder.largest().has_value());
}

TEST(test_the_largest_is_kept)
{
    check(4, HZ, found_in([](double t) { return (t > 1 && t < 2 ? 4 : 3) * sine(t); }, 3 * SECOND));
}

// A ripple was taken off that the signal does not have: what is left swings, the signal rests, or
// goes the other way.
TEST(test_a_swing_that_the_signal_does_not_make_is_none)
{
    const auto found_beside = [](double share) {
        nf::SwingFinder finder(LEAST, PERIOD_S);
        for (int k = 0; k < SECOND; k++) {
            const double left = 3 * sine(k * PERIOD_S);
            finder.add(left, 100 + share * left);
        }
        return finder.largest();
    };
    TEST_ASSERT_FALSE(found_beside(0).has_value());
    TEST_ASSERT_FALSE(found_beside(-1).has_value());
    TEST_ASSERT_FALSE(found_beside(0.49).has_value());
    check(3, HZ, found_beside(0.51));
}

} // namespace
