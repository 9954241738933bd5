// SPDX-License-Identifier: MIT
// R, what the legs lose, and the winding's warming, of levels of a motor that is known.
#include "config.h"
#include "known_motor.h"

#include <random>

#include "testing.h"

namespace
{

using namespace known;

constexpr double FITTED = 1e-4; // the method ends when the sum of squares hardly falls
constexpr double EXACT = 1e-12;
constexpr double MISMATCH = 0.02;
constexpr double WARMING = 0.03;
// The heat is that of the measured currents: a mismatch of 2 % is 2 % of the heat of an axis, of a
// warming of 3 %.
constexpr double WARM_FITTED = MISMATCH * WARMING;
constexpr double NOISE_V = 0.02;
constexpr double SIGMAS = 4;

Legs fitted(const Rest &rest)
{
    Records records = no_records();
    add_levels(records, rest);
    return fit_legs(records);
}

TEST(test_the_legs_of_a_known_motor_are_found)
{
    Rest rest;
    rest.mismatch = MISMATCH;
    const Legs found = fitted(rest);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * OHM, OHM, found.resistance_ohm.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * LOSS_V, LOSS_V, found.loss_v.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, KNEE_A, found.knee_a.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, MISMATCH, found.mismatch.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, 0, found.warming.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * BUS_V, BUS_V, found.bus_v);
}

// The lowest level lies far above most knees: 1/4000 of the largest current is not seen, and 0.5 %
// of the knee itself.
TEST(test_the_knee_has_the_bound_of_the_lowest_level_and_of_its_own)
{
    const Legs found = fitted({});
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, found.largest_a / 4000 + 0.005 * found.knee_a.value,
                              found.knee_a.bound);
}

// A supply that sags by 4 % under the largest current: the dead time takes its share of what is
// left.
TEST(test_the_loss_follows_a_bus_that_sags_under_the_current)
{
    Records records = no_records();
    add_levels(records, {});
    double mean_v = 0;
    for (Record &r : records.all) {
        const double more = 0.04 * (1 - r.i_a.real() / LARGEST_A);
        r.bus_v *= 1 + more;
        r.voltage_v += more * legs().lost_v(r.i_a).real();
        mean_v += r.bus_v / static_cast<double>(records.all.size());
    }
    const Legs found = fit_legs(records);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * OHM, OHM, found.resistance_ohm.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * LOSS_V, LOSS_V * mean_v / BUS_V, found.loss_v.value);
    // what is drop of the devices does not follow it: some of the correction is a bound
    TEST_ASSERT_TRUE(found.resistance_ohm.bound > fitted({}).resistance_ohm.bound);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, LOSS_V / 2, legs().at_bus(BUS_V / 2).loss_v.value);
}

TEST(test_the_resistance_is_that_of_the_beginning_of_a_winding_that_warms)
{
    Rest rest;
    rest.warming = WARMING;
    rest.mismatch = MISMATCH;
    const Legs found = fitted(rest);
    TEST_ASSERT_DOUBLE_WITHIN(WARM_FITTED * OHM, OHM, found.resistance_ohm.value);
    TEST_ASSERT_DOUBLE_WITHIN(WARM_FITTED, WARMING, found.warming.value);
    TEST_ASSERT_DOUBLE_WITHIN(WARM_FITTED * OHM, OHM * (1 + WARMING), found.warm_ohm());
}

// It does not show against what differs between the axes: R is that in the middle, and the bound
// has the rest of it.
TEST(test_a_small_warming_is_in_the_bound)
{
    Rest rest;
    rest.warming = 0.008;
    const Legs found = fitted(rest);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, 0, found.warming.value);
    TEST_ASSERT_TRUE(found.resistance_ohm.value > OHM);
    TEST_ASSERT_TRUE(found.resistance_ohm.value - OHM < found.resistance_ohm.bound);
}

// No winding cools down below its temperature at the beginning.
TEST(test_a_resistance_that_falls_is_no_warming)
{
    Rest rest;
    rest.warming = -0.03;
    const Legs found = fitted(rest);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, 0, found.warming.value);
}

double noise_v()
{
    static std::mt19937 engine(1);
    static std::normal_distribution<double> normal(0, NOISE_V);
    return normal(engine);
}

TEST(test_noise_is_in_the_standard_deviation)
{
    Rest rest;
    rest.noise_v = noise_v;
    const Legs found = fitted(rest);
    TEST_ASSERT_TRUE(found.resistance_ohm.std > 0);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * found.resistance_ohm.std, OHM, found.resistance_ohm.value);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * found.loss_v.std, LOSS_V, found.loss_v.value);
    // that of a line through 42 levels, and of a loss that is fitted too: no more than three times
    // of it
    TEST_ASSERT_TRUE(found.resistance_ohm.std < 3 * NOISE_V / std::sqrt(42.0) / (LARGEST_A / 4));
}

// Of five measurements: their deviations are as large as is said of them, to a factor that so few
// tell.
TEST(test_the_deviation_of_the_knee_is_in_its_own_unit)
{
    constexpr int MEASURED = 5;
    constexpr double FACTOR = 2.5; // 95 % of sums of five squares are within
    double squares = 0;
    double expected = 0;
    Rest rest;
    rest.noise_v = noise_v;
    for (int k = 0; k < MEASURED; k++) {
        const Legs found = fitted(rest);
        squares += std::pow(found.knee_a.value - KNEE_A, 2);
        expected += std::pow(found.knee_a.std, 2);
    }
    TEST_ASSERT_TRUE(std::sqrt(squares) < FACTOR * std::sqrt(expected));
    TEST_ASSERT_TRUE(std::sqrt(squares) > std::sqrt(expected) / FACTOR);
}

TEST(test_a_phase_of_another_resistance_shows_on_its_axis)
{
    constexpr double MORE = 0.03;
    Records records = no_records();
    add_levels(records, {});
    for (Record &r : records.all) {
        r.voltage_v += OHM * MORE * (r.axis == 2 ? 1 : -0.5) * r.i_a;
    }
    const Legs found = fit_legs(records);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, MORE, found.third.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * OHM, OHM, found.resistance_ohm.value);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED, 0, found.mismatch.value);
}

// A step of the timer is a share of the bus: more of it is less sure, as is what is known of a
// voltage by its scale.
TEST(test_a_higher_bus_widens_the_bounds)
{
    Records records = no_records();
    add_levels(records, {});
    const Legs found = fit_legs(records);
    for (Record &r : records.all) {
        r.bus_v *= 2;
    }
    const Legs higher = fit_legs(records);
    TEST_ASSERT_TRUE(higher.resistance_ohm.bound > found.resistance_ohm.bound);
    TEST_ASSERT_TRUE(higher.loss_v.bound > found.loss_v.bound);
    TEST_ASSERT_TRUE(higher.mismatch.bound > found.mismatch.bound);
}

double much_noise_v()
{
    return 15 * noise_v();
}

// Noise of 0.3 V makes a rise of R unsure by about 1 %: one that is half as large again is not told
// from it.
TEST(test_a_warming_that_noise_may_be_is_in_the_bound)
{
    Rest rest;
    rest.warming = 0.015;
    rest.noise_v = much_noise_v;
    const Legs found = fitted(rest);
    TEST_ASSERT_EQUAL_DOUBLE(0, found.warming.value);
    TEST_ASSERT_TRUE(found.warming.bound > 0.01);
}

TEST(test_too_few_levels_are_refused)
{
    Rest rest;
    rest.levels = 3;
    try {
        fitted(rest);
        TEST_FAIL_MESSAGE("nine levels have been taken");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING("the records have too few levels of current at rest: the "
                                 "identification did not come that far",
                                 error.what());
    }
}

TEST(test_the_ripple_widens_the_bounds)
{
    Legs rippling = legs();
    add_ripple_bounds(rippling, D_H);
    TEST_ASSERT_TRUE(rippling.resistance_ohm.bound > 0);
    Legs more = legs();
    add_ripple_bounds(more, D_H / 2);
    TEST_ASSERT_TRUE(more.resistance_ohm.bound > 2 * rippling.resistance_ohm.bound);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2 * rippling.loss_v.bound, more.loss_v.bound);
}

// The ripple is R·T/L of the current: of twice the R there is as much current less, and the knee is
// a current.
TEST(test_the_ripple_moves_the_knee_by_a_current)
{
    Legs one = legs();
    Legs twice = legs();
    twice.resistance_ohm.value *= 2;
    add_ripple_bounds(one, D_H);
    add_ripple_bounds(twice, D_H);
    TEST_ASSERT_TRUE(one.knee_a.bound > 0);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, one.knee_a.bound, twice.knee_a.bound);
}

// R takes all of the error, or the loss half.
TEST(test_a_current_that_is_unsure_widens_the_bounds)
{
    constexpr double SHARE = 0.01;
    Legs unsure = legs();
    add_unsure_current(unsure, SHARE);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, SHARE * OHM, unsure.resistance_ohm.bound);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, SHARE * OHM * LARGEST_A / 2, unsure.loss_v.bound);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, SHARE * LARGEST_A / 2, unsure.knee_a.bound);
}

// As many volts at each level: the loss has them all, R what they are of its largest voltage.
TEST(test_rounding_widens_the_bounds)
{
    constexpr double shift_a = 0.01;
    Legs rounded = legs();
    add_rounding_bounds(rounded, shift_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, OHM * shift_a, rounded.loss_v.bound);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, OHM * shift_a / LARGEST_A, rounded.resistance_ohm.bound);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, shift_a / LARGEST_A, rounded.mismatch.bound);
}

// knee.h: half of the slope of an ideal diode's step, and half of the loss at the knee.
TEST(test_a_leg_loses_half_at_its_knee)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, lost_share(0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5, lost_share(1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.95, lost_share(-10));
}

// On the axis of a phase the others carry half of the current.
TEST(test_the_loss_on_an_axis_is_that_of_three_legs)
{
    const double expected = 2.0 / 3 * (legs().lost_v(4.0) + legs().lost_v(2.0));
    const std::complex<double> lost = legs().lost_v(std::complex<double>(4, 0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, expected, lost.real());
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, lost.imag());
}

// 4/π of the loss is the fundamental of a square wave; a knee far below the current takes little of
// it.
TEST(test_the_turning_loss_of_hard_legs_is_that_of_a_square_wave)
{
    constexpr double angles = 0.01; // 48 of them, and a knee of 1/1000
    Legs hard = legs();
    hard.knee_a.value = LARGEST_A / 1000;
    TEST_ASSERT_DOUBLE_WITHIN(angles * LOSS_V, 4 / 3.14159265358979323846 * LOSS_V,
                              hard.lost_turning_v(LARGEST_A));
}

} // namespace
