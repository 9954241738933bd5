// SPDX-License-Identifier: MIT
// Flux linkage, inertia and friction of a known motor that turns, and two ways to the flux that do
// not agree.
#include "bars.h"
#include "config.h"
#include "turning_motor.h"

#include "testing.h"

namespace
{

using namespace known;

constexpr double EXACT = 1e-9;
// A window's mean speed over its time: the drag falls with the speed within it, by a tenth of a
// tenth.
constexpr double STEPPED = 0.02;

Flux flux_of(const Turning &t)
{
    return fit_flux(turning_records(t), legs(), inductances());
}

TEST(test_both_ways_find_the_flux)
{
    const Flux found = flux_of({});
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.turning_wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.coasting_wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.wb.value);
    TEST_ASSERT_TRUE(found.coasting_counts());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, TOP_EL, found.speed_el_rad_s);
}

// A wrong L makes the same of a current at each of its sizes: the line through both has none of it.
TEST(test_a_wrong_l_cancels)
{
    Inductances wrong = inductances();
    wrong.q_h.value *= 1.02;
    wrong.d_h.value *= 1.02;
    const Flux found = fit_flux(turning_records(), legs(), wrong);
    const double of_l = 0.02 * Q_H * SPIN_A; // what it is at the whole current
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * of_l, WB, found.turning_wb.value);
    // a third of what the line takes off, from half of the current to none
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * of_l, of_l / 2 / 3, found.turning_wb.std);
}

// Its inductance along the flux is half as large as across it.
TEST(test_the_flux_of_a_salient_rotor_is_that_of_its_magnets)
{
    Inductances salient = inductances();
    salient.d_h.value = Q_H / 2;
    Records records = turning_records();
    for (Record &r : records.all) {
        if (r.kind == "spin" || r.kind == "hold") {
            const double along_a = r.current_a * std::cos(LAG_RAD);
            const double wb = WB + (salient.d_h.value - salient.q_h.value) * along_a;
            const double torque = r.torque;
            r = turning(r.kind, r.speed_el_rad_s, r.current_a, wb);
            r.torque = torque;
        }
    }
    const Flux found = fit_flux(records, legs(), salient);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.turning_wb.value);
    for (const FluxAtSpeed &at : found.over_speed) {
        TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, at.wb.value);
    }
}

// ---- how sure ----

double square_of(const Value &value)
{
    return value.std * value.std + value.bound * value.bound;
}

double bar_of(const Value &value)
{
    return nf::error_bar(value.std, value.bound);
}

// The k-th window of coasting, from 0 on.
Record &coasting(Records &records, int k, const Turning &t)
{
    return records.all[records.all.size() - static_cast<std::size_t>(t.coast_windows - k)];
}

// The windows of coasting by turns larger and smaller by this share.
Records with_scatter(const Turning &t, double share)
{
    Records records = turning_records(t);
    for (int k = 0; k < t.coast_windows; k++) {
        coasting(records, k, t).voltage_v *= 1 + (k % 2 == 0 ? share : -share);
    }
    return records;
}

// ±e of six values: √(6/5)·e is their deviation, and 1/√6 of it that of their mean. Later windows
// are not among them.
TEST(test_the_scatter_of_coasting_is_that_of_the_mean_of_its_first_six_windows)
{
    constexpr double SHARE = 1e-3;
    Turning t;
    t.coast_windows = 12;
    Records records = with_scatter(t, SHARE);
    for (int k = 10; k < t.coast_windows; k++) { // 4 of them are not settled
        coasting(records, k, t).voltage_v *= 1.05;
    }
    const Value found = fit_flux(records, legs(), inductances()).coasting_wb;
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, SHARE * WB / std::sqrt(5.0), found.std);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.value);
}

TEST(test_each_way_to_the_flux_counts_by_the_square_of_the_others_bar)
{
    Turning t;
    t.coasting_wb = 1.001 * WB;
    Inductances wrong = inductances();
    wrong.q_h.value *= 1.02;
    const Flux found = fit_flux(with_scatter(t, 1e-3), legs(), wrong);
    const Value &turning = found.turning_wb;
    const Value &coasting = found.coasting_wb;
    const double share = square_of(coasting) / (square_of(turning) + square_of(coasting));
    TEST_ASSERT_TRUE(turning.std > 0 && coasting.std > 0 && std::abs(share - 0.5) > 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(0, found.disagreement_wb());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, share * turning.value + (1 - share) * coasting.value,
                              found.wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, std::hypot(share * turning.std, (1 - share) * coasting.std),
                              found.wb.std);
    // a bound of both together is added across
    TEST_ASSERT_TRUE(found.wb.bound > share * turning.bound + (1 - share) * coasting.bound);
}

TEST(test_what_two_ways_disagree_by_is_beyond_both_bars_and_half_of_it_is_a_bound)
{
    Turning t;
    t.coasting_wb = 1.08 * WB;
    const Flux found = flux_of(t);
    const double beyond = found.coasting_wb.value - found.turning_wb.value -
                          bar_of(found.turning_wb) - bar_of(found.coasting_wb);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, beyond, found.disagreement_wb());
    const double least = std::min(found.turning_wb.bound, found.coasting_wb.bound);
    TEST_ASSERT_TRUE(found.wb.bound > beyond / 2 + least);
}

// A coasting window that a current is left in: the legs lose between nothing and all of it.
void leave_current(Record &r, double left_a)
{
    r.i_a = std::complex<double>(0, left_a);
    const double lost = legs().lost_turning_v(left_a);
    r.voltage_v += std::complex<double>(0, OHM * left_a + lost / 2) * held(r.speed_el_rad_s);
}

TEST(test_a_current_that_is_left_of_coasting_is_in_the_bound_of_the_widest_window)
{
    constexpr double LEFT_A = 0.5;
    constexpr double EVENLY = 0.95;     // of a range in which all is alike likely
    constexpr double FLUX_SCALE = 1e-3; // of the voltage
    const Turning t;
    Records records = turning_records(t);
    Record &first = coasting(records, 4, t); // the first that is settled
    leave_current(first, LEFT_A);
    const Value found = fit_flux(records, legs(), inductances()).coasting_wb;
    const double half_wb = legs().lost_turning_v(LEFT_A) / 2 / first.speed_el_rad_s;
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, EVENLY * half_wb + FLUX_SCALE * (WB - half_wb), found.bound);
}

// All that is known of it is the loss itself, of which more is less sure.
TEST(test_what_the_legs_lose_while_turning_is_in_the_bound)
{
    Legs more = legs();
    more.loss_v.value *= 2;
    const Flux found = flux_of({});
    const Flux with_more = fit_flux(turning_records(), more, inductances());
    TEST_ASSERT_TRUE(with_more.turning_wb.bound > 1.5 * found.turning_wb.bound);
    TEST_ASSERT_TRUE(with_more.wb.bound > 1.5 * found.wb.bound);
}

TEST(test_a_window_with_too_much_voltage_is_left_out_too)
{
    Records records = turning_records();
    records.all.back().voltage_v *= 1.2;
    const Flux found = fit_flux(records, legs(), inductances());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.coasting_wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, found.coasting_wb.std);
}

// 1500 ticks: three windows of 500. One window alone agrees with nothing.
TEST(test_two_windows_behind_the_first_1500_ticks_are_a_coasting)
{
    Turning t;
    t.coast_ticks = 500;
    t.coast_windows = 4;
    TEST_ASSERT_FALSE(flux_of(t).has_coasted);
    t.coast_windows = 5;
    TEST_ASSERT_TRUE(flux_of(t).has_coasted);
}

// Two that agree by luck are as unsure as each of them.
TEST(test_ways_that_agree_keep_their_bound)
{
    const Flux found = flux_of({});
    const double least = std::min(found.turning_wb.bound, found.coasting_wb.bound);
    TEST_ASSERT_TRUE(least > 0);
    TEST_ASSERT_TRUE(found.wb.bound >= least);
}

TEST(test_a_disagreement_beyond_the_bars_widens_the_bound)
{
    Turning t;
    t.coasting_wb = 1.08 * WB;
    const Flux found = flux_of(t);
    TEST_ASSERT_TRUE(found.disagreement_wb() > 0.04 * WB);
    TEST_ASSERT_TRUE(found.coasting_counts());
    TEST_ASSERT_TRUE(found.wb.bound > found.disagreement_wb() / 2);
    TEST_ASSERT_TRUE(found.wb.value > WB && found.wb.value < 1.08 * WB);
}

// It is not hidden: coasting windows are compared with each other, not with the spin.
TEST(test_a_large_disagreement_is_seen_and_the_spin_alone_counts)
{
    Turning t;
    t.coasting_wb = 1.4 * WB;
    const Flux found = flux_of(t);
    TEST_ASSERT_TRUE(found.has_coasted);
    TEST_ASSERT_FALSE(found.coasting_counts());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1.4 * WB, found.coasting_wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.wb.value);
}

TEST(test_a_window_of_a_rotor_that_stands_is_left_out)
{
    Records records = turning_records();
    records.all.back().voltage_v *= 0.1;
    const Flux found = fit_flux(records, legs(), inductances());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.coasting_wb.value);
}

// The frame has not found the rotor before the end.
TEST(test_a_rotor_that_stops_at_once_has_not_coasted)
{
    Turning t;
    t.coast_windows = 3;
    const Flux found = flux_of(t);
    TEST_ASSERT_FALSE(found.has_coasted);
    TEST_ASSERT_FALSE(found.coasting_counts());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.wb.value);
}

TEST(test_the_flux_over_the_speed_is_that_of_the_three_spins)
{
    Turning t;
    t.slow_wb = 0.9 * WB;
    const Flux found = flux_of(t);
    TEST_ASSERT_EQUAL_size_t(3, found.over_speed.size());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, TOP_EL / 4, found.over_speed[0].speed_el_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.9 * WB, found.over_speed[0].wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.9 * WB, found.over_speed[1].wb.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, WB, found.over_speed[2].wb.value);
    // an error of R or of the legs falls with the speed
    TEST_ASSERT_TRUE(found.over_speed[0].wb.bound > 3 * found.over_speed[2].wb.bound);
}

TEST(test_inertia_and_friction_are_found)
{
    const Records records = turning_records();
    const Shaft found = fit_shaft(records, legs(), fit_flux(records, legs(), inductances()));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, INERTIA, found.inertia_kg_m2.value);
    TEST_ASSERT_DOUBLE_WITHIN(STEPPED * VISCOUS, VISCOUS, found.viscous_nm_s.value);
    TEST_ASSERT_DOUBLE_WITHIN(STEPPED * COULOMB, COULOMB, found.coulomb_nm.value);
    TEST_ASSERT_TRUE(found.inertia_kg_m2.bound > 0);
}

TEST(test_the_torque_of_a_current_that_is_left_of_coasting_is_no_friction)
{
    for (const double left_nm : {0.5 * COULOMB, -0.5 * COULOMB}) {
        Turning t;
        t.coast_nm = left_nm;
        const Records records = turning_records(t);
        const Shaft found = fit_shaft(records, legs(), fit_flux(records, legs(), inductances()));
        TEST_ASSERT_DOUBLE_WITHIN(STEPPED * VISCOUS, VISCOUS, found.viscous_nm_s.value);
        TEST_ASSERT_DOUBLE_WITHIN(STEPPED * COULOMB, COULOMB, found.coulomb_nm.value);
    }
}

// Four torques at constant speeds of 100 and 200 rad/s, each known to 0.002 of what the current
// pulls, and windows that err alike count as a fifth: however well they lie on a line, its slope is
// no surer than that.
TEST(test_friction_is_no_surer_than_the_torques_that_show_it)
{
    constexpr double UNSURE_NM = 2e-3 * TORQUE_FACTOR * WB * SPIN_A;
    constexpr double ALIKE = 5;
    constexpr double SCATTER = 1e-3;
    Turning t;
    t.coast_windows = 0;
    Records records = turning_records(t);
    int holds = 0;
    for (Record &r : records.all) {
        if (r.kind == "hold") { // the first pair has more, the second one less
            r.torque *= holds < 2 ? 1 + SCATTER : 1 - SCATTER;
            holds++;
        }
    }
    const Shaft found = fit_shaft(records, legs(), fit_flux(records, legs(), inductances()));
    const double spread = std::sqrt(4 * std::pow((TOP_EL - TOP_EL / 2) / POLE_PAIRS / 2, 2));
    const double expected = ALIKE * UNSURE_NM / spread;
    TEST_ASSERT_DOUBLE_WITHIN(SCATTER * expected, expected, found.viscous_nm_s.std);
    // and it follows J, by which coasting shows it
    const double unsure = bar_of(found.inertia_kg_m2) / found.inertia_kg_m2.value;
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, unsure * found.viscous_nm_s.value, found.viscous_nm_s.bound);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, unsure * found.coulomb_nm.value, found.coulomb_nm.bound);
}

// ---- a load that swings, and ramps that wait ----

// With the first ramp, ten times as long as the others, between the windows of half of the speed
// and of the whole.
Records with_slow_ramp()
{
    Records records = turning_records();
    Record slow = ramp(TOP_EL / 2, TOP_EL);
    slow.ticks *= 10;
    records.all.insert(records.all.begin() + 2, slow);
    return records;
}

Shaft shaft_of(const Records &records)
{
    return fit_shaft(records, legs(), fit_flux(records, legs(), inductances()));
}

TEST(test_a_rotor_with_all_that_it_turns_does_not_swing)
{
    const Shaft found = shaft_of(with_slow_ramp());
    TEST_ASSERT_FALSE(found.swings);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, INERTIA, found.inertia_kg_m2.value);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, shaft_of(turning_records()).inertia_kg_m2.bound,
                              found.inertia_kg_m2.bound);
}

// After each ramp the load still takes torque that is not friction: `share` of that of the ramp,
// after each other pair `other` times as much.
Records with_swing(double share, double other)
{
    Records records = with_slow_ramp();
    double ramp_torque = 0;
    int ramps = 0;
    for (Record &r : records.all) {
        if (r.kind == "ramp") {
            ramp_torque = r.torque / r.ticks - drag_nm(r.speed_el_rad_s) / TORQUE_FACTOR;
            ramps++;
        } else if (r.kind == "hold") {
            const bool is_other = (ramps / 2) % 2 == 0;
            r.torque += (is_other ? other : 1) * share * ramp_torque * r.ticks;
        }
    }
    return records;
}

// Up and down alike: no pair differs from another.
void expect_swing(double share, bool swings)
{
    const Shaft found = shaft_of(with_swing(share, 1));
    const Value &j = found.inertia_kg_m2;
    TEST_ASSERT_EQUAL(swings, found.swings);
    TEST_ASSERT_DOUBLE_WITHIN(std::hypot(2 * j.std, j.bound), INERTIA, j.value);
    TEST_ASSERT_TRUE(j.bound > shaft_of(with_slow_ramp()).inertia_kg_m2.bound);
}

TEST(test_a_torque_after_the_ramps_that_is_no_friction_widens_the_bar_and_a_large_one_is_named)
{
    expect_swing(0.08, false);
    expect_swing(0.3, true);
    expect_swing(-0.3, true);
}

TEST(test_torques_at_one_speed_that_differ_from_window_to_window_are_of_a_load_that_swings)
{
    TEST_ASSERT_FALSE(shaft_of(with_swing(0.08, -1)).swings);
    const Shaft found = shaft_of(with_swing(0.12, -1));
    TEST_ASSERT_TRUE(found.swings);
    // as far as they are apart
    TEST_ASSERT_TRUE(found.inertia_kg_m2.bound > 0.24 * found.inertia_kg_m2.value);
}

// Its window ends before the ramp does: of its impulse some is missing.
TEST(test_a_ramp_down_that_has_waited_for_the_bus_is_left_out)
{
    Records records = with_slow_ramp();
    Record late = ramp(TOP_EL, TOP_EL / 2);
    late.speed_el_rad_s = 0.85 * TOP_EL;
    late.torque /= 2;
    const auto first = records.all.begin() + 5;
    records.all.insert(first, {late, hold(TOP_EL / 2), ramp(TOP_EL / 2, TOP_EL), hold(TOP_EL)});
    const Shaft found = shaft_of(records);
    TEST_ASSERT_FALSE(found.swings);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, INERTIA, found.inertia_kg_m2.value);
}

// Where all have waited none is left out: what their windows may lack is a bound.
TEST(test_ramps_that_have_all_waited_make_the_inertia_less_sure_by_that)
{
    constexpr double WAITED = 0.06; // of the change of speed
    Records records = with_slow_ramp();
    for (Record &r : records.all) {
        if (r.kind == "ramp" && r.torque < 0) {
            r.speed_el_rad_s += WAITED * TOP_EL / 2;
        }
    }
    const Value found = shaft_of(records).inertia_kg_m2;
    TEST_ASSERT_TRUE(found.bound > WAITED * found.value);
}

// The drive has taken the loss of another bus voltage from the power.
TEST(test_braking_that_lifts_the_bus_changes_no_inertia)
{
    Records records = with_slow_ramp();
    for (Record &r : records.all) {
        if (r.kind == "ramp" && r.torque < 0) {
            r.bus_v *= 1.1;
            r.torque += 0.1 * legs().lost_turning_v(SPIN_A) * SPIN_A / r.speed_el_rad_s * r.ticks;
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, INERTIA, shaft_of(records).inertia_kg_m2.value);
}

TEST(test_ramps_that_show_no_inertia_are_refused_by_the_load)
{
    Records records = with_slow_ramp();
    for (Record &r : records.all) {
        r.torque *= r.kind == "ramp" ? -1 : 1;
    }
    try {
        shaft_of(records);
        TEST_FAIL_MESSAGE("a negative inertia has been taken");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL(0, std::string(error.what()).find("the load swings"));
    }
}

std::string refusal_of(const Records &records)
{
    try {
        fit_shaft(records, legs(), fit_flux(records, legs(), inductances()));
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

TEST(test_records_that_end_too_early_are_refused)
{
    Records records = turning_records();
    records.all.resize(1);
    TEST_ASSERT_EQUAL_STRING("the records end before the rotor has turned",
                             refusal_of(records).c_str());
    records.all = turning_records().all;
    records.all.resize(4);
    TEST_ASSERT_EQUAL_STRING("the records end before the ramps of speed",
                             refusal_of(records).c_str());
    records.all = {turning("spin", TOP_EL / 4, SPIN_A, WB),
                   turning("spin", TOP_EL, SPIN_A / 2, WB)};
    TEST_ASSERT_EQUAL_STRING("the records have no window at another current and the same speed",
                             refusal_of(records).c_str());
}

} // namespace
