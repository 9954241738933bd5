// SPDX-License-Identifier: MIT
// Flux linkage, inertia and friction of a known motor that turns, and two ways to the flux that do not agree.
#include "config.h"
#include "turning_motor.h"

#include "testing.h"

namespace
{

using namespace known;

constexpr double EXACT = 1e-9;
// A window's mean speed over its time: the drag falls with the speed within it, by a tenth of a tenth.
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

// ---- a load that swings, and ramps that wait ----

// With the first ramp, ten times as long as the others, between the windows of half of the speed and of the whole.
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

// After each ramp the load still takes torque that is not friction: `share` of that of the ramp, after each other pair
// `other` times as much.
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
