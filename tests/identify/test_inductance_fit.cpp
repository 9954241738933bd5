// SPDX-License-Identifier: MIT
// The model of a burst, and L over the current of bursts of a motor that is known.
#include "config.h"
#include "known_motor.h"

#include "testing.h"

namespace
{

using namespace known;

// A search ends at 1e-6; what is known of iron beforehand pulls at the curve with 1/50 of the weight of a burst.
constexpr double FITTED = 1e-3;
constexpr double BIAS_FALL = 0.15; // of L_d at the continuous current along
constexpr double PEAK_FALL = 0.2;  // of L_q, for pulses of it
constexpr double HALF_ROTOR = 0.5;
constexpr double MISMATCH = 0.02; // of the gain of the sensor of phase a against that of b

// An iron of which 1/L is what the fit takes it to be.
double d_h(double bias_a)
{
    return D_H / (1 + BIAS_FALL * bias_a / CONTINUOUS_A);
}

double q_h(double peak_a)
{
    return Q_H / (1 + PEAK_FALL * std::pow(peak_a / CONTINUOUS_A, 2));
}

Record burst(int axis, double bias_a, double pulse_v, bool across, int quarter)
{
    Record r;
    r.kind = "burst";
    r.axis = axis;
    r.current_a = bias_a;
    r.i_a = bias_a;
    r.pulse_v = pulse_v;
    r.across = across;
    r.quarter_ticks = quarter;
    r.ticks = 64.0 * quarter;
    r.bus_v = BUS_V;
    return r;
}

// Its change is what the model says for its L; across that depends on the change again.
void add_burst(Records &records, Record r)
{
    double inductance_h = r.across ? Q_H : d_h(r.current_a);
    double change_a = 0;
    for (int k = 0; k < 50; k++) {
        change_a = modelled_change(r, legs(), inductance_h);
        inductance_h = r.across ? q_h(change_a / r.ticks * r.quarter_ticks) : d_h(r.current_a);
    }
    r.change_a = r.across ? std::complex<double>(0, change_a) : std::complex<double>(change_a, 0);
    records.all.push_back(r);
}

Records bursts(int axes)
{
    Records records = no_records();
    for (int axis = 0; axis < axes; axis++) {
        for (const double share : {0.1875, 0.3125, 0.5, 1.0}) {
            add_burst(records, burst(axis, share * CONTINUOUS_A, 60, false, 1));
        }
        for (const double volts : {100.0, 150.0, 210.0}) {
            add_burst(records, burst(axis, 0.5, volts, true, 2));
        }
    }
    return records;
}

TEST(test_pulses_of_a_winding_without_loss_change_the_current_by_their_impulse_over_l)
{
    Legs lossless = legs();
    lossless.loss_v.value = 0;
    lossless.resistance_ohm.value = 0.01;
    const double decay = lossless.decay(D_H); // what R takes of it, at most
    const Record r = burst(0, 2, 60, false, 2);
    const double expected = 60 * PERIOD_S / D_H * r.ticks;
    TEST_ASSERT_DOUBLE_WITHIN(4 * decay * expected, expected, modelled_change(r, lossless, D_H));
}

// What the legs lose of a current that never changes its sign is the same in each pulse: it is held, and cancels.
TEST(test_the_loss_of_a_large_bias_cancels)
{
    Legs hard = legs();
    hard.knee_a.value = 1e-6;
    hard.resistance_ohm.value = 0.01;
    const Record r = burst(0, 8, 60, false, 2);
    const double expected = 60 * PERIOD_S / D_H * r.ticks;
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * expected, expected, modelled_change(r, hard, D_H));
}

TEST(test_l_over_the_current_is_found)
{
    const Inductances found = fit_inductances(bursts(3), legs(), CONTINUOUS_A);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * D_H, D_H, found.d_h.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, CONTINUOUS_A, found.current_a);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * Q_H, q_h(CONTINUOUS_A), found.q_h.value);
    TEST_ASSERT_EQUAL_size_t(4, found.d_over_current.size());
    for (const AtCurrent &point : found.d_over_current) {
        TEST_ASSERT_DOUBLE_WITHIN(FITTED * D_H, d_h(point.current_a), point.h.value);
    }
    TEST_ASSERT_EQUAL_size_t(3, found.q_over_current.size());
    for (const AtCurrent &point : found.q_over_current) {
        TEST_ASSERT_DOUBLE_WITHIN(FITTED * Q_H, q_h(point.current_a), point.h.value);
    }
}

// The bar of L_q is that of the curve where it is stated: the last of its points, but for what the curve does not follow.
TEST(test_the_deviation_is_that_at_the_stated_current)
{
    Records records = bursts(3);
    for (std::size_t k = 0; k < records.all.size(); k++) {
        records.all[k].change_a *= k % 2 == 0 ? 1.002 : 0.998;
    }
    const Inductances found = fit_inductances(records, legs(), CONTINUOUS_A);
    TEST_ASSERT_TRUE(found.q_h.std > 0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * Q_H, found.q_h.value, found.q_over_current.back().h.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * Q_H, found.q_h.std, found.q_over_current.back().h.std);
    // a curve is surer within its points than where it is extrapolated to, at no current
    TEST_ASSERT_TRUE(found.d_over_current[1].h.std < found.d_h.std);
}

TEST(test_a_current_beyond_the_pulses_is_theirs)
{
    const Inductances found = fit_inductances(bursts(3), legs(), 100);
    TEST_ASSERT_TRUE(found.current_a < 6);
}

// Across the axis of one phase the sensor of the other sees the pulses. Gains that were taken off the wrong way round would cancel
// in the mean of three axes, and stay as scatter.
TEST(test_the_gains_of_the_sensors_are_taken_off_each_axis)
{
    Legs unlike = legs();
    unlike.mismatch.value = MISMATCH;
    Records records = bursts(3);
    for (Record &r : records.all) {
        r.change_a *= gain(r.axis, r.across ? -MISMATCH : MISMATCH);
    }
    const Inductances found = fit_inductances(records, unlike, CONTINUOUS_A);
    const Inductances expected = fit_inductances(bursts(3), legs(), CONTINUOUS_A);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * D_H, expected.d_h.value, found.d_h.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * D_H, expected.d_h.std, found.d_h.std);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * Q_H, expected.q_h.value, found.q_h.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * Q_H, expected.q_h.std, found.q_h.std);
}

// A rotor that moves makes the change larger by a third of its stiffness times the square of the quarter over L.
TEST(test_the_rotor_that_moves_is_taken_off_by_the_quarter_of_each_burst)
{
    const double quarter_s = 2 * PERIOD_S;
    const double rotor_h_s2 = HALF_ROTOR * Q_H / (quarter_s * quarter_s);
    const Inductances still = fit_inductances(bursts(3), legs(), CONTINUOUS_A);
    const Inductances moving =
        fit_inductances(bursts(3), legs(), CONTINUOUS_A, {rotor_h_s2, false});
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * Q_H, HALF_ROTOR / 3 * Q_H, moving.q_h.value - still.q_h.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, still.d_h.value, moving.d_h.value);
}

TEST(test_too_few_bursts_are_refused)
{
    try {
        fit_inductances(bursts(1), legs(), CONTINUOUS_A);
        TEST_FAIL_MESSAGE("three bursts across have been taken");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING("the records have too few pulses at rest: the identification did "
                                 "not come that far",
                                 error.what());
    }
}

} // namespace
