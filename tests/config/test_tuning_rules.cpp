// SPDX-License-Identifier: MIT
// The rules of the tuning `any`, each at dimensionless numbers where its value is known:
// docs/tuning_rules.md.
#include "nn_observer_units.h"
#include "rules.h"

#include "config.h"
#include "numbers.h"
#include "speed_margin.h"

#include "testing.h"

#include <cmath>

namespace
{

// Settings go through a few products of doubles.
constexpr double RELATIVE = 1e-9;

nf::Config any(const std::vector<std::string> &set = {}, const std::vector<std::string> &with = {})
{
    return nf::load_parts("motor_a", "bench_310v", "any", with, set);
}

nf::TuningSettings ruled(const std::vector<std::string> &set = {},
                         const std::vector<std::string> &with = {})
{
    const nf::Config c = any(set, with);
    return nf::by_rules(c.tuning, c.motor, c.board, c.model);
}

void expect(double expected, double actual)
{
    TEST_ASSERT_DOUBLE_WITHIN(RELATIVE * std::abs(expected), expected, actual);
}

// 4.3·a/ω with a = 1.5·2·0.387·10/0.003 rad/s² and 1800 rpm.
constexpr double LOOP_RAD_S = 4.3 * 3870 / (60 * 3.14159265358979323846);
constexpr double PERIOD_S = 1e-4;

// The lag is 8.1·T/κ_p, and 2πf times it is 0.165.
TEST(the_observer_is_as_slow_as_its_speed_loop_allows)
{
    const nf::TuningSettings t = ruled();
    expect(8.1 * LOOP_RAD_S / 0.165 * PERIOD_S, t.observer_kappa_p);
    expect(t.observer_kappa_p * t.observer_kappa_p / 8.1, t.observer_kappa);
    expect(0.165, LOOP_RAD_S * nf::estimate_lag_s(t, PERIOD_S));
    expect(LOOP_RAD_S, 2 * nf::PI * t.speed_bandwidth_hz);
}

// With a hundred times J the loop would allow a rate of 43/s; the rotor turns with 377 rad/s.
TEST(the_observer_is_not_slower_than_the_rotor_turns)
{
    const nf::TuningSettings t = ruled({"motor.inertia_kg_m2=0.3"});
    expect(2 * 2 * nf::PI * 30 * PERIOD_S, t.observer_kappa_p);
}

// A tenth of J asks for κ_p = 4.3: it stays at 0.45, and the loop waits for a lag of 18 periods.
TEST(a_light_rotor_gets_the_speed_loop_and_ramp_that_the_lag_allows)
{
    const nf::TuningSettings t = ruled({"motor.inertia_kg_m2=0.0003"});
    const double lag = 18 * PERIOD_S;
    expect(0.45, t.observer_kappa_p);
    expect(0.025, t.observer_kappa);
    expect(0.165 / lag, 2 * nf::PI * t.speed_bandwidth_hz);
    expect(0.0105 * 1800 / lag, t.speed_ramp_rpm_s);
}

// At 3 µs and 310 V a leg loses 12.4 V, and the EMF at a tenth of rated speed is 14.59 V: the loop
// has 0.15·ω·14.59/12.4.
TEST(dead_time_slows_the_speed_loop_and_its_observer)
{
    const double omega = 2 * 2 * nf::PI * 30;
    const double rate = 0.15 * omega * (0.1 * omega * 0.387) / (4.0 / 3 * 310 * 3e-6 * 1e4);
    const nf::TuningSettings t = ruled({"board.dead_time_s=3e-6"});
    expect(rate, 2 * nf::PI * t.speed_bandwidth_hz);
    expect(8.1 * rate / 0.165 * PERIOD_S, t.observer_kappa_p);
    const nf::TuningSettings written =
        ruled({"board.dead_time_s=3e-6", "observer.kappa=0.025", "observer.kappa_p=0.45"});
    expect(0.165 / (18 * PERIOD_S) < LOOP_RAD_S ? 0.165 / (18 * PERIOD_S) : LOOP_RAD_S,
           2 * nf::PI * written.speed_bandwidth_hz);
}

// As above, with a tenth of J: the torque asks for at least 205/s, which is more than dead time
// allows at the hand-over.
TEST(dead_time_slows_the_loop_of_a_light_rotor_at_low_speed_alone)
{
    const std::vector<std::string> light = {"board.dead_time_s=3e-6", "motor.inertia_kg_m2=0.0003"};
    const double omega = 2 * 2 * nf::PI * 30;
    const double rate = 0.15 * omega * (0.1 * omega * 0.387) / (4.0 / 3 * 310 * 3e-6 * 1e4);
    const nf::TuningSettings t = ruled(light);
    TEST_ASSERT_TRUE(2 * nf::PI * t.speed_bandwidth_hz > rate);
    expect(rate, 2 * nf::PI * t.low_speed_bandwidth_hz);
    const nf::Config c = any(light);
    const speed_loop_cfg_t loop = nf::build(c).speed_loop;
    const double steps_per_rpm = 2 / 60.0 * 1e-4 * 4294967296.0;
    const double limit_rpm = 180 * t.speed_bandwidth_hz / t.low_speed_bandwidth_hz;
    TEST_ASSERT_DOUBLE_WITHIN(1, limit_rpm * steps_per_rpm, loop.soft_speed);
    // Without dead time the two are one.
    const nf::Config quiet = any({"board.dead_time_s=0"});
    TEST_ASSERT_EQUAL_INT32(0, nf::build(quiet).speed_loop.soft_speed);
}

TEST(a_speed_loop_that_is_written_faster_has_an_observer_as_fast)
{
    const nf::TuningSettings t = ruled({"speed_loop.bandwidth_hz=14.5"});
    TEST_ASSERT_EQUAL_DOUBLE(14.5, t.speed_bandwidth_hz);
    expect(8.1 * 2 * nf::PI * 14.5 / 0.165 * PERIOD_S, t.observer_kappa_p);
}

// The published law has no lag, and its least κ is twice what it is stable with.
TEST(the_published_law_is_damped_at_the_highest_speed)
{
    const nf::TuningSettings slow = ruled({"observer.kappa_p=0"});
    expect(0.025, slow.observer_kappa);
    expect(LOOP_RAD_S, 2 * nf::PI * slow.speed_bandwidth_hz);
    const nf::TuningSettings fast = ruled({"observer.kappa_p=0", "board.pwm_frequency_hz=4000"});
    const double turn = 2 * 2 * nf::PI * 2000 / 60 / 4000;
    expect(std::max(0.025, 3 * turn * turn), fast.observer_kappa);
    expect(3 * turn * turn, fast.observer_kappa);
}

// A proportional path ten times as fast as the rotor turns has 1, one of 12.5 times and more 1.25.
TEST(rho_is_smaller_where_the_observer_is_slow)
{
    const nf::TuningSettings t = ruled();
    expect(0.1 * t.observer_kappa_p / PERIOD_S / (2 * 2 * nf::PI * 30), t.observer_rho_max);
    expect(1, ruled({"motor.inertia_kg_m2=0.03"}).observer_rho_max);
    expect(1.25, ruled({"motor.rated_speed_rpm=500"}).observer_rho_max);
}

// T·R/L of motor A is 0.01832 at 10 kHz, with R six times as large 0.11.
TEST(an_error_of_the_network_loses_a_tenth_in_a_sample)
{
    const double winding = PERIOD_S * 2.125 / 0.0116;
    expect(0.1 - winding, ruled().observer_feedback);
    expect(0, ruled({"motor.resistance_ohm=12.75"}).observer_feedback);
}

// A rotor that turns little in a sample is seen through little feedback: three times its angle,
// here 0.0226.
TEST(the_network_forgets_no_faster_than_three_times_as_the_rotor_turns)
{
    const double winding = PERIOD_S * 2.125 / 0.0116;
    const double turn = 2 * 2 * nf::PI * 30 * PERIOD_S;
    expect((3 * turn - winding) / 5, ruled({"board.pwm_frequency_hz=50000"}).observer_feedback);
}

TEST(the_current_loop_has_twenty_samples_in_its_period)
{
    expect(500, ruled().current_bandwidth_hz);
    expect(1000, ruled({"board.pwm_frequency_hz=20000"}).current_bandwidth_hz);
}

// Rated current 7.8/(3·0.387) A makes 14.28 V across R. The loss of a leg is 4/3 of 310 V·t_d·10
// kHz.
TEST(dead_time_raises_the_least_current)
{
    const double drop_v = 2.125 * 7.8 / (3 * 0.387);
    expect(18, ruled().current_floor_pct);
    expect(18 + 40 * (4.0 / 3 * 3.1) / drop_v, ruled({"board.dead_time_s=1e-6"}).current_floor_pct);
    expect(50, ruled({"board.dead_time_s=3e-6", "board.bus_nominal_v=340"}).current_floor_pct);
}

// The circle is 0.95·bus/√3; what 0.95 of it leaves above the EMF of 145.9 V drives i_d through ωL
// = 4.373 Ω at 8.4 A.
TEST(the_least_current_leaves_voltage_at_rated_speed)
{
    const double omega = 2 * 2 * nf::PI * 30;
    const double spare_v = 0.95 * 0.95 * 310 / std::sqrt(3.0) - omega * 0.387;
    expect(100 * spare_v / (omega * 0.0116 * 8.4),
           ruled({"board.dead_time_s=3e-6"}).current_floor_pct);
    expect(18, ruled({"board.dead_time_s=3e-6", "board.bus_nominal_v=285"}).current_floor_pct);
}

// 1.5 times the hold's, within the largest current and the room that over-current leaves for a
// swing.
TEST(the_alignment_imposes_more_than_the_hold)
{
    const std::vector<std::string> room = {"motor.max_current_a=15", "board.overcurrent_a=18",
                                           "motor.continuous_current_a=6"};
    const startup_cfg_t c = nf::build(any(room)).startup;
    const double one = 32768.0 / 40;
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 6 * one, c.current_hold);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 9 * one, c.align.current_high);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 0.62 * 9 * one, c.align.current_low);
    std::vector<std::string> off = room;
    off.emplace_back("startup.align_current_pct=0");
    const startup_cfg_t same = nf::build(any(off)).startup;
    TEST_ASSERT_EQUAL_INT32(same.current_hold, same.align.current_high);
    std::vector<std::string> tight = room;
    tight.emplace_back("board.overcurrent_a=15");
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 15 / 1.8 * one,
                              nf::build(any(tight)).startup.align.current_high);
}

TEST(what_is_written_is_not_changed)
{
    const nf::TuningSettings t =
        ruled({"observer.kappa=0.02", "observer.kappa_p=0.3", "observer.rho_max=0.7",
               "observer.feedback=0.02", "current_loop.bandwidth_hz=321",
               "current_loop.floor_pct=11", "speed_loop.bandwidth_hz=3",
               "speed_loop.ramp_rpm_s=999", "voltage_loop.virtual_resistance_ohm=0"},
              {"deadtime"});
    TEST_ASSERT_EQUAL_DOUBLE(0.02, t.observer_kappa);
    TEST_ASSERT_EQUAL_DOUBLE(0.3, t.observer_kappa_p);
    TEST_ASSERT_EQUAL_DOUBLE(0.7, t.observer_rho_max);
    TEST_ASSERT_EQUAL_DOUBLE(0.02, t.observer_feedback);
    TEST_ASSERT_EQUAL_DOUBLE(321, t.current_bandwidth_hz);
    TEST_ASSERT_EQUAL_DOUBLE(11, t.current_floor_pct);
    TEST_ASSERT_EQUAL_DOUBLE(3, t.speed_bandwidth_hz);
    TEST_ASSERT_EQUAL_DOUBLE(999, t.speed_ramp_rpm_s);
    TEST_ASSERT_EQUAL_DOUBLE(0, t.virtual_resistance_ohm);
    expect(std::sqrt(8.1 * 0.02), ruled({"observer.kappa=0.02"}).observer_kappa_p);
}

// 0.45·ω·L, of two axes the harmonic mean; and a mean that follows within 0.6 of a radian. At 2000
// Hz a sample takes off 0.17 of a change with a rated speed of 3600 rpm, and with 4500 rpm it would
// take off 0.21.
TEST(the_virtual_resistance_is_a_share_of_the_reactance)
{
    const double omega = 2 * 2 * nf::PI * 30;
    const nf::TuningSettings t = ruled();
    expect(0.45 * omega * 0.0116, t.virtual_resistance_ohm);
    expect(1 / (0.6 * omega), t.virtual_mean_s);
    expect(0.45 * omega * 2 / (1 / 0.0116 + 1 / 0.02),
           ruled({"motor.inductance_q_h=0.02"}).virtual_resistance_ohm);
    const std::string slow = "board.pwm_frequency_hz=2000";
    expect(0.9 * omega * 0.0116,
           ruled({slow, "motor.rated_speed_rpm=3600"}).virtual_resistance_ohm);
    expect(0.2 * 0.0116 * 2000, ruled({slow, "motor.rated_speed_rpm=4500"}).virtual_resistance_ohm);
    // of the axis that changes faster
    for (const char *smaller : {"motor.inductance_q_h=0.01", "motor.inductance_d_h=0.01"}) {
        expect(0.2 * 0.01 * 2000,
               ruled({slow, "motor.rated_speed_rpm=4500", smaller}).virtual_resistance_ohm);
    }
}

constexpr double DEGREE = 2 * nf::PI / 360;

// What shows the angle, what i_d > 0 takes of the voltage and where a braking lead ends: all by
// L_d, however large L_q is.
TEST(the_rules_of_a_salient_motor_take_the_inductance_along_its_flux)
{
    const std::string salient = "motor.inductance_q_h=0.02";
    const double omega = 2 * 2 * nf::PI * 30;
    expect(0.1 - PERIOD_S * 2.125 / 0.0116, ruled({salient}).observer_feedback);
    expect(0.8 * std::atan(2.125 / (omega * 0.0116)) / DEGREE, ruled({salient}).brake_max_deg);
    const double spare_v = 0.95 * 0.95 * 310 / std::sqrt(3.0) - omega * 0.387;
    expect(100 * spare_v / (omega * 0.0116 * 8.4),
           ruled({salient, "board.dead_time_s=3e-6"}).current_floor_pct);
    // X = 0.302 slows the speed loop to less than half of what the torque allows.
    const double reactance = 0.0174 * 7.8 / (3 * 0.387) / 0.387;
    expect(0.5 * omega / (reactance * reactance) * 0.165 / 8.1 / (2 * nf::PI),
           ruled({"motor.inductance_d_h=0.0174", salient}).speed_bandwidth_hz);
}

double margin_deg(const nf::TuningSettings &t, nf::TorqueFilter filter)
{
    return nf::speed_margin(t, PERIOD_S, t.speed_bandwidth_hz, filter) / DEGREE;
}

// Without lag, period and current loop the PI has the open loop (2s + 1)/s² with its gain 1 at s =
// j·√(2 + √5): atan 4.116.
TEST(the_speed_loop_has_the_margin_of_its_design)
{
    nf::TuningSettings t = ruled({"drive.angle_source=sensor"});
    t.slow_ticks = 0;
    t.speed_bandwidth_hz = 1e-3;
    const double design = std::atan(2 * std::sqrt(2 + std::sqrt(5.0))) / DEGREE;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, design, margin_deg(t, nf::TorqueFilter::none));
    // A delay turns by 2πf times itself; at 2.058 mHz · 1 s of a period of 2 s by 0.741°.
    t.slow_ticks = 20000;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, design - 360 * 2.058e-3, margin_deg(t, nf::TorqueFilter::none));
}

TEST(a_torque_filter_slows_the_speed_loop_until_its_margin_is_what_it_was)
{
    const nf::TuningSettings rigid = ruled();
    const double margin = margin_deg(rigid, nf::TorqueFilter::none);
    TEST_ASSERT_DOUBLE_WITHIN(5, 45, margin);
    for (const char *filter : {"speed_loop.notch_hz=200", "speed_loop.notch_hz=40",
                               "speed_loop.notch_hz=10", "speed_loop.torque_filter_hz=60"}) {
        const nf::TuningSettings t = ruled({filter});
        TEST_ASSERT_TRUE(t.speed_bandwidth_hz < rigid.speed_bandwidth_hz);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, margin, margin_deg(t, nf::TorqueFilter::as_set));
        TEST_ASSERT_EQUAL_DOUBLE(rigid.observer_kappa_p, t.observer_kappa_p);
        expect(t.speed_bandwidth_hz / 2.8, t.position_bandwidth_hz);
    }
    // Written, it stays.
    TEST_ASSERT_EQUAL_DOUBLE(
        14, ruled({"speed_loop.notch_hz=40", "speed_loop.bandwidth_hz=14"}).speed_bandwidth_hz);
}

// Up to the notch the loop would have to be 2.058 times as fast as its bandwidth.
TEST(a_notch_within_the_speed_loop_leaves_no_margin)
{
    const nf::TuningSettings t = ruled({"speed_loop.notch_hz=40", "speed_loop.bandwidth_hz=19.5"});
    TEST_ASSERT_EQUAL_DOUBLE(-180, margin_deg(t, nf::TorqueFilter::as_set));
    const double most = nf::bandwidth_of_margin(t, PERIOD_S, 0, 60);
    TEST_ASSERT_TRUE(2.058 * most < 40);
    TEST_ASSERT_EQUAL_DOUBLE(1, nf::bandwidth_of_margin(t, PERIOD_S, 0, 1));
}

// A sensor's speed does not lag: nothing is capped.
TEST(a_sensor_does_not_slow_the_speed_loop)
{
    const nf::TuningSettings t = ruled({"drive.angle_source=sensor", "motor.inertia_kg_m2=0.0003"});
    expect(10 * LOOP_RAD_S, 2 * nf::PI * t.speed_bandwidth_hz);
    expect(0, nf::estimate_lag_s(t, PERIOD_S));
}

} // namespace
