// SPDX-License-Identifier: MIT
// Metrics on made-up signals whose figures are known in closed form.
#include "metrics.h"

#include <cmath>
#include <functional>

#include "testing.h"

namespace
{

constexpr double PERIOD_S = 1e-3;
constexpr double RATED_RPM = 2000;
constexpr double RATED_A = 10;
constexpr double EXACT = 1e-9;

using nf::DriveMode;
using nf::Instant;
using nf::Metrics;
using nf::MetricValues;

// A drive without any error that follows its command: what the tests change is what they are about.
Instant perfect(double actual)
{
    Instant now{};
    now.actual = actual;
    now.speed_rpm = actual;
    now.speed_estimated_rpm = actual;
    now.running = true;
    return now;
}

void run(Metrics &metrics, int ticks, const std::function<Instant(int)> &signal)
{
    for (int k = 0; k < ticks; k++) {
        metrics.add(signal(k));
    }
}

void check_within(double tolerance, double expected, const std::optional<double> &value)
{
    TEST_ASSERT_TRUE(value.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected, *value);
}

void check(double expected, const std::optional<double> &value)
{
    check_within(EXACT, expected, value);
}

TEST(test_estimation_errors)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 100, [](int k) {
        Instant now = perfect(0);
        now.speed_estimated_rpm = k < 50 ? 3.0 : -4.0;
        now.angle_error_deg = k == 10 ? -7.0 : 2.0;
        now.iq_error_a = k == 20 ? -0.5 : 0.25;
        return now;
    });
    const MetricValues m = metrics.finish();
    check(4.0, m.speed_error_max_rpm);
    check(0.2, m.speed_error_max_pct);
    check(std::sqrt((9.0 + 16.0) / 2.0), m.speed_error_rms_rpm);
    check(7.0, m.angle_error_max_deg);
    check(std::sqrt((99 * 4.0 + 49.0) / 100.0), m.angle_error_rms_deg);
    check(0.5, m.iq_error_max_a);
    TEST_ASSERT_TRUE(m.locked);
}

TEST(test_lock_is_lost_at_90_degrees)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 10, [](int k) {
        Instant now = perfect(0);
        now.angle_error_deg = k == 5 ? -90.0 : 89.9;
        return now;
    });
    TEST_ASSERT_FALSE(metrics.finish().locked);
}

bool locked_with_speed_error(double share, double seconds)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, static_cast<int>(std::lround(seconds / PERIOD_S)), [share](int k) {
        Instant now = perfect(0);
        now.speed_estimated_rpm = share * RATED_RPM * (k % 2 == 0 ? 1.0 : -1.0);
        return now;
    });
    return metrics.finish().locked;
}

// An error of share e reaches a mean square of (5 %)² after −0.1 s·ln(1 − (5 %/e)²), whatever its
// sign.
TEST(test_lock_is_lost_with_a_speed_error_that_lasts)
{
    const double loses_s = -nf::LOST_MEAN_S * std::log(1.0 - 0.25); // 10 %: 28.8 ms
    TEST_ASSERT_TRUE(locked_with_speed_error(0.10, loses_s - PERIOD_S));
    TEST_ASSERT_FALSE(locked_with_speed_error(0.10, loses_s + PERIOD_S));
    TEST_ASSERT_TRUE(locked_with_speed_error(0.049, 10.0));
    TEST_ASSERT_FALSE(locked_with_speed_error(1.67, PERIOD_S));
}

// A command of 3 % of rated speed, and an estimate that swings about it by a share of the command:
// against rated speed that is little.
MetricValues with_error_of_command(double share, double seconds)
{
    constexpr double command = 0.03 * RATED_RPM;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.start(command);
    run(metrics, static_cast<int>(std::lround(seconds / PERIOD_S)), [share](int k) {
        Instant now = perfect(command);
        now.time_s = k * PERIOD_S;
        now.speed_estimated_rpm += share * command * (k % 2 == 0 ? 1.0 : -1.0);
        return now;
    });
    return metrics.finish();
}

// Its mean square begins with the settled window and reaches (25 %)² after −0.1 s·ln(1 − (25
// %/e)²).
TEST(test_lock_is_lost_with_a_speed_error_that_is_large_for_the_command)
{
    const double loses_s = nf::SETTLED_AFTER_S - nf::LOST_MEAN_S * std::log(1.0 - 0.25);
    TEST_ASSERT_TRUE(with_error_of_command(0.5, loses_s - PERIOD_S).locked);
    const MetricValues lost = with_error_of_command(0.5, loses_s + 2 * PERIOD_S);
    TEST_ASSERT_FALSE(lost.locked);
    TEST_ASSERT_TRUE(lost.locked_coarse);
    check_within(PERIOD_S, loses_s, lost.lost_time_s);
    TEST_ASSERT_TRUE(with_error_of_command(0.24, 10.0).locked);
    TEST_ASSERT_FALSE(with_error_of_command(0.24, 10.0).lost_time_s.has_value());
}

MetricValues with_angle_error(double degrees, bool closed_loop, double seconds)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, static_cast<int>(std::lround(seconds / PERIOD_S)), [&](int k) {
        Instant now = perfect(0);
        now.angle_error_deg = degrees * (k % 2 == 0 ? 1.0 : -1.0);
        now.closed_loop = closed_loop;
        return now;
    });
    return metrics.finish();
}

// 60° for −0.1 s·ln(1 − (30/60)²). An imposed current holds a load at any angle below 90°.
TEST(test_lock_is_lost_with_an_angle_error_that_lasts_in_closed_loop)
{
    const double loses_s = -nf::LOST_MEAN_S * std::log(1.0 - 0.25);
    TEST_ASSERT_TRUE(with_angle_error(60, true, loses_s - PERIOD_S).locked);
    TEST_ASSERT_FALSE(with_angle_error(60, true, loses_s + PERIOD_S).locked);
    TEST_ASSERT_TRUE(with_angle_error(60, true, loses_s + PERIOD_S).locked_coarse);
    TEST_ASSERT_TRUE(with_angle_error(29.9, true, 10.0).locked);
    TEST_ASSERT_TRUE(with_angle_error(60, false, 10.0).locked);
}

TEST(test_closed_loop_begins_its_mean_anew)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 1000, [](int k) {
        Instant now = perfect(0);
        now.angle_error_deg = 60;
        now.closed_loop = k % 20 != 0; // 19 ms are too short to lose it
        return now;
    });
    TEST_ASSERT_TRUE(metrics.finish().locked);
}

TEST(test_speed_errors_of_command_and_load_steps_are_told_apart)
{
    const auto with_error = [](double error) {
        return [error](int k) {
            Instant now = perfect(0);
            now.speed_estimated_rpm = k == 5 ? error : 0;
            return now;
        };
    };
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 10, with_error(300)); // before any step
    metrics.command_step(100);
    run(metrics, 10, with_error(-40));
    metrics.load_step();
    run(metrics, 10, with_error(20));
    metrics.command_step(200);
    metrics.load_step(); // with the command's
    run(metrics, 10, with_error(30));
    metrics.command_step(300);
    run(metrics, 10, with_error(10));
    const MetricValues m = metrics.finish();
    check(2.0, m.speed_error_command_pct);
    check(1.5, m.speed_error_load_pct);
}

// A sine of 10 Hz; half a sample from its top it has fallen by 1 − cos(π/100). The rotor makes so
// many electrical turns in a second.
MetricValues with_swing(double speed_rpm, double current_a, bool moving, double turns = 0)
{
    constexpr double pi = 3.14159265358979323846;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 1000, [&](int k) {
        const double sine = std::sin(2 * pi * 10 * k * PERIOD_S);
        Instant now = perfect(RATED_RPM + speed_rpm * sine);
        now.i_q_a = current_a * sine;
        now.angle_el_rad = std::remainder(2 * pi * turns * k * PERIOD_S, 2 * pi);
        now.reference_moving = moving && k % 100 == 0;
        return now;
    });
    return metrics.finish();
}

TEST(test_a_swing_of_speed_or_current_is_a_limit_cycle)
{
    constexpr double top = 0.0005;
    const MetricValues both = with_swing(100, 5, false);
    TEST_ASSERT_TRUE(both.limit_cycle);
    TEST_ASSERT_TRUE(both.locked);
    check_within(top * 5, 5, both.swing_speed_pct);
    check_within(top * 50, 50, both.swing_current_pct);
    check_within(0.1, 10, both.swing_hz);
    TEST_ASSERT_TRUE(with_swing(0, 1.01 * nf::SWING_CURRENT * RATED_A, false).limit_cycle);
    TEST_ASSERT_TRUE(with_swing(1.01 * nf::SWING_SPEED * RATED_RPM, 0, false).limit_cycle);
    const MetricValues ripple =
        with_swing(0.99 * nf::SWING_SPEED * RATED_RPM, 0.99 * nf::SWING_CURRENT * RATED_A, false);
    TEST_ASSERT_FALSE(ripple.limit_cycle);
    TEST_ASSERT_FALSE(ripple.swing_hz.has_value());
}

// With three turns in the settled part a swing at order 2.8 lies two periods and more from the
// orders 2 and 6.
TEST(test_a_ripple_that_the_rotor_forces_is_no_limit_cycle)
{
    constexpr double top = 0.0005;
    const MetricValues m = with_swing(100, 5, false, 5); // of order 2
    TEST_ASSERT_FALSE(m.limit_cycle);
    check_within(top * 5, 5, m.ripple_speed_pct);
    check_within(top * 50, 50, m.ripple_current_pct);
    TEST_ASSERT_TRUE(with_swing(100, 5, false, 10.0 / 2.8).limit_cycle);
    const MetricValues slow =
        with_swing(100, 5, false, 2); // less than two turns once it has settled
    TEST_ASSERT_TRUE(slow.limit_cycle);
    TEST_ASSERT_FALSE(slow.ripple_speed_pct.has_value());
    TEST_ASSERT_FALSE(slow.ripple_current_pct.has_value());
}

// Where the reference moves the speed has to change.
TEST(test_a_limit_cycle_needs_a_constant_command)
{
    TEST_ASSERT_FALSE(with_swing(100, 5, true).limit_cycle);
}

// Faults that follow each other more quickly than three periods make no swing that the drive
// sustains.
TEST(test_what_disturbs_the_drive_from_outside_is_no_limit_cycle)
{
    const auto limit_cycle = [](int ticks_between) {
        constexpr double pi = 3.14159265358979323846;
        Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
        for (int k = 0; k < 1000; k++) {
            if (k % ticks_between == 0) {
                metrics.disturbed();
            }
            metrics.add(perfect(RATED_RPM + 100 * std::sin(2 * pi * 10 * k * PERIOD_S)));
        }
        return metrics.finish().limit_cycle;
    };
    TEST_ASSERT_FALSE(limit_cycle(250)); // 2.5 periods
    TEST_ASSERT_TRUE(limit_cycle(500));
}

// It settles at a share of the way from 100 to 200 rpm, in two windows of which the second is one
// of load.
MetricValues approached(double share)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.start(100);
    run(metrics, 50, [](int) { return perfect(100); });
    metrics.command_step(200);
    run(metrics, 50, [](int) { return perfect(100); });
    metrics.load_step();
    run(metrics, 50, [share](int k) { return perfect(100 + 100 * share * k / 49); });
    return metrics.finish();
}

TEST(test_a_command_is_reached_within_a_share_of_its_step)
{
    TEST_ASSERT_TRUE(approached(0.951).reached);
    TEST_ASSERT_FALSE(approached(0.951).missed.has_value());
    const MetricValues missed = approached(0.949);
    TEST_ASSERT_FALSE(missed.reached);
    TEST_ASSERT_TRUE(missed.locked);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 200, missed.missed->command);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 194.9, missed.missed->nearest);
}

TEST(test_the_first_command_that_was_missed_is_told)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.start(100);
    run(metrics, 10, [](int) { return perfect(90); });
    metrics.command_step(0);
    run(metrics, 10, [](int) { return perfect(0); });
    TEST_ASSERT_EQUAL_DOUBLE(100, metrics.finish().missed->command);
}

// A command of 0 from the beginning asks for nothing, and a torque has figures of its own.
TEST(test_where_nothing_is_asked_for_nothing_is_missed)
{
    Metrics still(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    still.start(0);
    run(still, 10, [](int) { return perfect(1); });
    TEST_ASSERT_TRUE(still.finish().reached);
    Metrics torque(DriveMode::torque, PERIOD_S, RATED_RPM, RATED_A);
    torque.start(0);
    torque.command_step(5);
    run(torque, 10, [](int) { return perfect(1); });
    TEST_ASSERT_TRUE(torque.finish().reached);
}

TEST(test_lock_is_lost_when_the_drive_stops)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 10, [](int k) {
        Instant now = perfect(0);
        now.running = k != 9;
        return now;
    });
    TEST_ASSERT_FALSE(metrics.finish().locked);
}

TEST(test_nothing_applies_without_steps_and_time)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 10, [](int) { return perfect(0); });
    const MetricValues m = metrics.finish();
    TEST_ASSERT_FALSE(m.settling_time_s.has_value());
    TEST_ASSERT_FALSE(m.overshoot_pct.has_value());
    TEST_ASSERT_FALSE(m.speed_dip_rpm.has_value());
    TEST_ASSERT_FALSE(m.recovery_time_s.has_value());
    TEST_ASSERT_FALSE(m.command_error_settled_pct.has_value());
    TEST_ASSERT_FALSE(m.id_settled_a.has_value());
    TEST_ASSERT_FALSE(m.position_error_final_rad.has_value());
}

TEST(test_no_ticks_are_not_locked)
{
    TEST_ASSERT_FALSE(Metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A).finish().locked);
}

// First-order answer to a step of 1000: within 2 % (20) after τ·ln 50, no overshoot.
TEST(test_settling_time_of_a_first_order_lag)
{
    constexpr double TAU_S = 0.05;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.start(500);
    metrics.command_step(1500);
    run(metrics, 1000,
        [](int k) { return perfect(1500.0 - 1000.0 * std::exp(-k * PERIOD_S / TAU_S)); });
    const MetricValues m = metrics.finish();
    TEST_ASSERT_TRUE(m.settling_time_s.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(PERIOD_S, TAU_S * std::log(50.0), *m.settling_time_s);
    check(0.0, m.overshoot_pct);
}

// Downwards, the overshoot is below the command; of two steps the worse one counts.
TEST(test_overshoot_of_the_worst_step)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.command_step(100);
    run(metrics, 50, [](int k) { return perfect(k == 10 ? 105.0 : 100.0); });
    metrics.command_step(-100);
    run(metrics, 50, [](int k) { return perfect(k == 10 ? -130.0 : -100.0); });
    const MetricValues m = metrics.finish();
    check(15.0, m.overshoot_pct);
    check(11 * PERIOD_S, m.settling_time_s);
}

TEST(test_a_step_that_does_not_settle_has_no_settling_time)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.command_step(100);
    run(metrics, 50, [](int) { return perfect(97.0); });
    metrics.command_step(0);
    run(metrics, 50, [](int) { return perfect(0.0); });
    TEST_ASSERT_FALSE(metrics.finish().settling_time_s.has_value());
}

TEST(test_dip_and_recovery)
{
    constexpr double BAND_RPM = nf::RECOVERY_BAND * RATED_RPM;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.start(1000);
    run(metrics, 20, [](int) { return perfect(1000); });
    metrics.load_step();
    run(metrics, 100, [](int k) { return perfect(k < 30 ? 960.0 : 1000.0 - BAND_RPM); });
    metrics.load_step();
    run(metrics, 100, [](int k) { return perfect(k < 10 ? 1050.0 : 1000.0); });
    const MetricValues m = metrics.finish();
    check(50.0, m.speed_dip_rpm);
    check(30 * PERIOD_S, m.recovery_time_s);
    TEST_ASSERT_FALSE(m.settling_time_s.has_value());
}

TEST(test_a_load_step_with_a_command_step_has_no_dip)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.command_step(1000);
    metrics.load_step();
    run(metrics, 100, [](int) { return perfect(1000); });
    const MetricValues m = metrics.finish();
    TEST_ASSERT_FALSE(m.speed_dip_rpm.has_value());
    check(0.0, m.settling_time_s);
}

// 150 ticks after the step, or after the reference has stopped moving, and not before.
TEST(test_settled_window_begins_after_the_ramp)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    metrics.command_step(1000);
    run(metrics, 400, [](int k) {
        Instant now = perfect(k < 249 ? 0.0 : 998.0);
        now.reference_moving = k < 100;
        now.i_d_a = k < 249 ? 9.0 : k % 2 == 0 ? 0.5 : -0.1;
        return now;
    });
    const MetricValues m = metrics.finish();
    check(0.2, m.command_error_settled_pct);
    check((75 * 0.5 - 76 * 0.1) / 151, m.id_settled_a);
}

TEST(test_settled_error_at_standstill_is_of_rated_speed)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 200, [](int) { return perfect(-10); });
    check(0.5, metrics.finish().command_error_settled_pct);
}

TEST(test_id_settled_is_the_worst_window)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM, RATED_A);
    for (const double i_d : {0.1, -0.4, 0.2}) {
        metrics.load_step();
        run(metrics, 300, [i_d](int) {
            Instant now = perfect(0);
            now.i_d_a = i_d;
            return now;
        });
    }
    check(0.4, metrics.finish().id_settled_a);
}

TEST(test_final_position_error_is_taken_at_the_end_of_each_command)
{
    Metrics metrics(DriveMode::position, PERIOD_S, RATED_RPM, RATED_A);
    run(metrics, 50, [](int) { return perfect(0.01); });
    metrics.command_step(10);
    run(metrics, 50, [](int k) { return perfect(k < 49 ? 0.0 : 10.02); });
    metrics.command_step(-10);
    run(metrics, 50, [](int k) { return perfect(k < 49 ? 0.0 : -10.0); });
    const MetricValues m = metrics.finish();
    check(0.02, m.position_error_final_rad);
    TEST_ASSERT_FALSE(m.command_error_settled_pct.has_value());
    TEST_ASSERT_FALSE(m.speed_dip_rpm.has_value());
}

} // namespace
