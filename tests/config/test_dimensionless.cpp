// SPDX-License-Identifier: MIT
// The dimensionless numbers of a drive, against motor A's worked out by hand.
#include "config.h"
#include "dimensionless.h"

#include <cmath>
#include <map>
#include <string>

#include "testing.h"

namespace
{

constexpr double PI = 3.14159265358979323846;
constexpr double EXACT = 1e-9; // of the value: the same formulas in another order

using Numbers = std::map<std::string, double>;

Numbers numbers(const std::vector<std::string> &set = {})
{
    Numbers found;
    for (const nf::Dimensionless &one :
         nf::dimensionless(nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {}, set))) {
        found[one.name] = one.value;
    }
    return found;
}

void expect(double value, const Numbers &found, const char *name)
{
    TEST_ASSERT_EQUAL_size_t_MESSAGE(1, found.count(name), name);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(EXACT * std::abs(value), value, found.at(name), name);
}

// 7.8 N·m and 0.387 Wb at two pole pairs: 6.718 A; 1800 rpm: 377 rad/s, 145.9 V.
constexpr double CURRENT = 7.8 / (3 * 0.387);
constexpr double OMEGA = 120 * PI;
constexpr double EMF = OMEGA * 0.387;

TEST(of_the_motor)
{
    const Numbers found = numbers();
    expect(2.125 * CURRENT / EMF, found, "copper");
    expect(OMEGA * 0.0116 * CURRENT / EMF, found, "reactance");
    expect(2.125 / 0.0116 / 10000, found, "decay");
    expect(1, found, "saliency");
    expect(std::sqrt(2 * 7.8 / 0.003) / (0.1 * OMEGA), found, "swing");
    expect(60 * PI * 0.003 / 7.8 * 10000, found, "inertia");
}

TEST(of_the_board)
{
    const Numbers found =
        numbers({"board.dead_time_s=1e-6", "board.device_drop_v=1", "motor.max_speed_rpm=2000",
                 "board.overcurrent_a=18", "motor.max_current_a=10", "board.duty_margin_pct=5"});
    const double dead_time = 4.0 / 3 * (310 * 1e-6 * 10000 + 1);
    expect(dead_time / (2.125 * CURRENT), found, "dead_time");
    expect(dead_time / (0.1 * EMF), found, "dead_time_emf");
    expect(2000 * PI / 30 * 2 / 10000, found, "turn");
    expect(20.0 / 2048 / CURRENT, found, "converter");
    expect(310 / 10000.0 / 12 / 0.0116 / CURRENT, found, "pwm_ripple");
    expect(1.8, found, "overcurrent");
    const double along_q = EMF + 2.125 * CURRENT / 2;
    const double along_d = OMEGA * 0.0116 * CURRENT / 2;
    expect(std::hypot(along_q, along_d) / (0.95 * 310 / std::sqrt(3.0)), found, "voltage");
}

TEST(of_the_tuning)
{
    const std::vector<std::string> set = {"observer.kappa=0.02", "observer.kappa_p=0.4",
                                          "speed_loop.bandwidth_hz=5", "speed_loop.ramp_rpm_s=900",
                                          "current_loop.bandwidth_hz=400"};
    const Numbers found = numbers(set);
    expect(2 * PI * 5 * 20 / 10000, found, "speed_lag");
    expect(900 * 20 / 10000.0 / 1800, found, "ramp_lag");
    expect(2 * PI * 400 / 10000, found, "current_loop");
}

// A sensor has no lag.
TEST(without_the_integral_there_is_no_lag)
{
    expect(0, numbers({"drive.angle_source=sensor"}), "speed_lag");
}

} // namespace
