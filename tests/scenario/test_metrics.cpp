// SPDX-License-Identifier: MIT
// Metrics on made-up signals whose figures are known in closed form.
#include "metrics.h"

#include <cmath>
#include <functional>

#include <unity.h>

namespace
{

constexpr double PERIOD_S = 1e-3;
constexpr double RATED_RPM = 2000;
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

void check(double expected, const std::optional<double> &value)
{
    TEST_ASSERT_TRUE(value.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, expected, *value);
}

void test_estimation_errors()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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
    check(0.5, m.iq_error_max_a);
    TEST_ASSERT_TRUE(m.locked);
}

void test_lock_is_lost_at_90_degrees()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    run(metrics, 10, [](int k) {
        Instant now = perfect(0);
        now.angle_error_deg = k == 5 ? -90.0 : 89.9;
        return now;
    });
    TEST_ASSERT_FALSE(metrics.finish().locked);
}

bool locked_with_speed_error(double share, double seconds)
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    run(metrics, static_cast<int>(std::lround(seconds / PERIOD_S)), [share](int k) {
        Instant now = perfect(0);
        now.speed_estimated_rpm = share * RATED_RPM * (k % 2 == 0 ? 1.0 : -1.0);
        return now;
    });
    return metrics.finish().locked;
}

// An error of share e reaches a mean square of (5 %)² after −0.1 s·ln(1 − (5 %/e)²), whatever its sign.
void test_lock_is_lost_with_a_speed_error_that_lasts()
{
    const double loses_s = -nf::LOST_SPEED_S * std::log(1.0 - 0.25); // 10 %: 28.8 ms
    TEST_ASSERT_TRUE(locked_with_speed_error(0.10, loses_s - PERIOD_S));
    TEST_ASSERT_FALSE(locked_with_speed_error(0.10, loses_s + PERIOD_S));
    TEST_ASSERT_TRUE(locked_with_speed_error(0.049, 10.0));
    TEST_ASSERT_FALSE(locked_with_speed_error(1.67, PERIOD_S));
}

void test_lock_is_lost_when_the_drive_stops()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    run(metrics, 10, [](int k) {
        Instant now = perfect(0);
        now.running = k != 9;
        return now;
    });
    TEST_ASSERT_FALSE(metrics.finish().locked);
}

void test_nothing_applies_without_steps_and_time()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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

void test_no_ticks_are_not_locked()
{
    TEST_ASSERT_FALSE(Metrics(DriveMode::speed, PERIOD_S, RATED_RPM).finish().locked);
}

// First-order answer to a step of 1000: within 2 % (20) after τ·ln 50, no overshoot.
void test_settling_time_of_a_first_order_lag()
{
    constexpr double TAU_S = 0.05;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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
void test_overshoot_of_the_worst_step()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    metrics.command_step(100);
    run(metrics, 50, [](int k) { return perfect(k == 10 ? 105.0 : 100.0); });
    metrics.command_step(-100);
    run(metrics, 50, [](int k) { return perfect(k == 10 ? -130.0 : -100.0); });
    const MetricValues m = metrics.finish();
    check(15.0, m.overshoot_pct);
    check(11 * PERIOD_S, m.settling_time_s);
}

void test_a_step_that_does_not_settle_has_no_settling_time()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    metrics.command_step(100);
    run(metrics, 50, [](int) { return perfect(97.0); });
    metrics.command_step(0);
    run(metrics, 50, [](int) { return perfect(0.0); });
    TEST_ASSERT_FALSE(metrics.finish().settling_time_s.has_value());
}

void test_dip_and_recovery()
{
    constexpr double BAND_RPM = nf::RECOVERY_BAND * RATED_RPM;
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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

void test_a_load_step_with_a_command_step_has_no_dip()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    metrics.command_step(1000);
    metrics.load_step();
    run(metrics, 100, [](int) { return perfect(1000); });
    const MetricValues m = metrics.finish();
    TEST_ASSERT_FALSE(m.speed_dip_rpm.has_value());
    check(0.0, m.settling_time_s);
}

// 150 ticks after the step, or after the reference has stopped moving, and not before.
void test_settled_window_begins_after_the_ramp()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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

void test_settled_error_at_standstill_is_of_rated_speed()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
    run(metrics, 200, [](int) { return perfect(-10); });
    check(0.5, metrics.finish().command_error_settled_pct);
}

void test_id_settled_is_the_worst_window()
{
    Metrics metrics(DriveMode::speed, PERIOD_S, RATED_RPM);
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

void test_final_position_error_is_taken_at_the_end_of_each_command()
{
    Metrics metrics(DriveMode::position, PERIOD_S, RATED_RPM);
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

void setUp()
{
}

void tearDown()
{
}

int main()
{
    UNITY_BEGIN();
    RUN_TEST(test_estimation_errors);
    RUN_TEST(test_lock_is_lost_at_90_degrees);
    RUN_TEST(test_lock_is_lost_with_a_speed_error_that_lasts);
    RUN_TEST(test_lock_is_lost_when_the_drive_stops);
    RUN_TEST(test_nothing_applies_without_steps_and_time);
    RUN_TEST(test_no_ticks_are_not_locked);
    RUN_TEST(test_settling_time_of_a_first_order_lag);
    RUN_TEST(test_overshoot_of_the_worst_step);
    RUN_TEST(test_a_step_that_does_not_settle_has_no_settling_time);
    RUN_TEST(test_dip_and_recovery);
    RUN_TEST(test_a_load_step_with_a_command_step_has_no_dip);
    RUN_TEST(test_settled_window_begins_after_the_ramp);
    RUN_TEST(test_settled_error_at_standstill_is_of_rated_speed);
    RUN_TEST(test_id_settled_is_the_worst_window);
    RUN_TEST(test_final_position_error_is_taken_at_the_end_of_each_command);
    return UNITY_END();
}
