// SPDX-License-Identifier: MIT
// The model of a burst, and L over the current of bursts of a motor that is known.
#include "config.h"
#include "known_motor.h"

#include <algorithm>

#include "testing.h"

namespace
{

using namespace known;

// A search ends at 1e-6; what is known of iron beforehand pulls at the curve with 1/50 of the
// weight of a burst.
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

// What the legs lose of a current that never changes its sign is the same in each pulse: it is
// held, and cancels.
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

// The bar of L_q is that of the curve where it is stated: the last of its points, but for what the
// curve does not follow.
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

// What a low pass that may be hidden changes of L_q is a bound of it: as much at the last point of
// the curve, which adds what it does not follow.
TEST(test_the_bound_of_the_curve_of_a_salient_motor_is_that_of_l_q)
{
    constexpr double SALIENT = 2;
    constexpr double CURVE = 2e-3;
    Records records = bursts(3);
    for (Record &r : records.all) {
        r.change_a /= r.across ? SALIENT : 1;
    }
    const Inductances found = fit_inductances(records, legs(), CONTINUOUS_A);
    TEST_ASSERT_TRUE(found.q_h.value > 1.5 * D_H);
    const Value &last = found.q_over_current.back().h;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * Q_H, found.q_h.bound + CURVE * found.q_h.value, last.bound);
}

TEST(test_a_current_beyond_the_pulses_is_theirs)
{
    const Inductances found = fit_inductances(bursts(3), legs(), 100);
    TEST_ASSERT_TRUE(found.current_a < 6);
}

// Across the axis of one phase the sensor of the other sees the pulses. Gains that were taken off
// the wrong way round would cancel in the mean of three axes, and stay as scatter.
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

// A rotor that moves makes the change larger by a third of its stiffness times the square of the
// quarter over L.
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

// ---- what bursts show beside L ----

constexpr double LAG_S = PERIOD_S / 5;

// The bursts of some axes, along or across.
Records bursts_of(int axes, bool across)
{
    Records records = bursts(axes);
    records.all.erase(std::remove_if(records.all.begin(), records.all.end(),
                                     [&](const Record &r) { return r.across != across; }),
                      records.all.end());
    return records;
}

// With two bursts along each current, of which the second takes half of the voltage for twice as
// long, seen by sensors behind a low pass; that one is larger by `share` for one current, and
// smaller for the other.
Records pairs_behind(double lag_s, double share)
{
    Records records = bursts_of(2, true);
    for (int axis = 0; axis < 2; axis++) {
        for (const double bias_a : {2.0, 3.0}) {
            for (const int quarter : {1, 2}) {
                Record r = burst(axis, bias_a, 60.0 / quarter, false, quarter);
                r.change_a = modelled_change(r, legs(), d_h(bias_a), lag_s);
                r.change_a *= quarter == 1 ? 1 : bias_a < 2.5 ? 1 + share : 1 - share;
                records.all.push_back(r);
            }
        }
    }
    return records;
}

TEST(test_the_low_pass_of_the_sensors_is_found_by_pairs_of_pulses)
{
    const SensorLag found = fit_inductances(pairs_behind(LAG_S, 0), legs(), CONTINUOUS_A).lag;
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * LAG_S, LAG_S, found.s.value);
    // of what pairs show without a low pass, which is some thousandths of L
    TEST_ASSERT_TRUE(found.s.bound > 0 && found.s.bound < LAG_S / 2);
    TEST_ASSERT_EQUAL_DOUBLE(0, found.hidden_s);
}

// Pairs without a difference hide none; those of two currents that differ by turns may hide a
// little.
TEST(test_a_low_pass_that_chance_may_hide_is_a_bound)
{
    const SensorLag none = fit_inductances(pairs_behind(0, 0), legs(), CONTINUOUS_A).lag;
    TEST_ASSERT_EQUAL_DOUBLE(0, none.s.value);
    const SensorLag hidden = fit_inductances(pairs_behind(0, 1e-3), legs(), CONTINUOUS_A).lag;
    TEST_ASSERT_EQUAL_DOUBLE(0, hidden.s.value);
    TEST_ASSERT_TRUE(hidden.hidden_s > none.hidden_s);
    TEST_ASSERT_TRUE(hidden.hidden_s < LAG_S);
}

// Pulses across of two lengths, which turn the rotor by its share of L in the square of the longer
// quarter.
constexpr int LONGER = 4;

double rotor_of(double share)
{
    return share * Q_H / std::pow(LONGER * PERIOD_S, 2);
}

Records turning_bursts(double rotor_h_s2)
{
    Records records = bursts_of(2, false);
    for (const double volts : {100.0, 150.0, 200.0}) {
        for (const int quarter : {2, LONGER}) {
            Record r = burst(0, 0.5, 2 * volts / quarter, true, quarter);
            const double less_h = rotor_h_s2 * std::pow(quarter * PERIOD_S, 2) / 3;
            r.change_a = std::complex<double>(0, modelled_change(r, legs(), Q_H - less_h));
            records.all.push_back(r);
        }
    }
    return records;
}

TEST(test_a_rotor_that_turns_further_than_is_known_is_found_by_the_length_of_the_pulses)
{
    constexpr double SHARE = 0.3;
    constexpr double SQUARED =
        SHARE * SHARE / 3; // 1/L is taken to fall with the square of the quarter
    const Inductances found = fit_inductances(turning_bursts(rotor_of(SHARE)), legs(), CONTINUOUS_A,
                                              {rotor_of(0.01), false});
    TEST_ASSERT_DOUBLE_WITHIN(SQUARED / SHARE * rotor_of(SHARE), rotor_of(SHARE), found.alone_h_s2);
    TEST_ASSERT_DOUBLE_WITHIN(SQUARED * Q_H, Q_H, found.q_h.value);
    // one that turns less than is known is that which is known
    const Inductances less =
        fit_inductances(turning_bursts(0), legs(), CONTINUOUS_A, {rotor_of(SHARE), false});
    TEST_ASSERT_EQUAL_DOUBLE(0, less.alone_h_s2);
}

// The ramps have shown that the load swings: then a little is believed that would be chance
// otherwise.
TEST(test_of_a_load_that_swings_a_little_more_is_believed)
{
    const Records records = turning_bursts(rotor_of(0.02));
    const double known = rotor_of(0.001);
    constexpr double TURN_KNOWN = 2e-3; // of L: pulses do not show less of a turn
    const Inductances stiff = fit_inductances(records, legs(), CONTINUOUS_A, {known, false});
    const Inductances swinging = fit_inductances(records, legs(), CONTINUOUS_A, {known, true});
    TEST_ASSERT_EQUAL_DOUBLE(0, stiff.alone_h_s2);
    TEST_ASSERT_TRUE(swinging.alone_h_s2 > known);
    // what is not known of it is a bound
    const Inductances still = fit_inductances(turning_bursts(0), legs(), CONTINUOUS_A);
    TEST_ASSERT_TRUE(swinging.q_h.bound > still.q_h.bound + TURN_KNOWN * Q_H);
    TEST_ASSERT_TRUE(stiff.q_h.bound > still.q_h.bound + TURN_KNOWN * Q_H);
}

// L of axis a is larger by `more`, and from burst to burst by turns by `scatter` more and less.
AxisShares axes_with(double more, double scatter)
{
    Records records = bursts(3);
    int along = 0;
    for (Record &r : records.all) {
        if (r.axis == 0 && !r.across) {
            r.change_a /= 1 + more + (along % 2 == 0 ? scatter : -scatter);
            along++;
        }
    }
    return fit_inductances(records, legs(), CONTINUOUS_A).axes;
}

// Of ln(1 + more) two thirds on this axis and minus a third on the others. What the legs lose and R
// takes is not of L: a tenth.
TEST(test_an_axis_of_more_inductance_shows_with_its_sign)
{
    constexpr double MORE = 0.02;
    constexpr double LOST = 0.1;
    const AxisShares found = axes_with(MORE, 0);
    const double third = std::log(1 + MORE) / 3;
    TEST_ASSERT_DOUBLE_WITHIN(LOST * third, 2 * third, found.share[0]);
    TEST_ASSERT_DOUBLE_WITHIN(LOST * third, -third, found.share[1]);
    TEST_ASSERT_DOUBLE_WITHIN(LOST * third, -third, found.share[2]);
    TEST_ASSERT_DOUBLE_WITHIN(LOST * third, 0, found.std);
}

// Four bursts of ±e on one axis of three: against the mean of the three they scatter by 2/3·e²
// together with the others, of two degrees of freedom; the mean of four has a quarter of that:
// e²/12.
TEST(test_what_an_axis_scatters_by_is_the_deviation_of_its_mean)
{
    constexpr double SCATTER = 5e-3;
    constexpr double LOST = 0.1;
    const double expected = SCATTER / std::sqrt(12.0);
    TEST_ASSERT_DOUBLE_WITHIN(LOST * expected, expected, axes_with(0, SCATTER).std);
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
