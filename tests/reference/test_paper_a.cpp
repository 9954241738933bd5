// SPDX-License-Identifier: MIT
// The firmware beside paper A (paper_a.h): figures of S1 to S3 as published, and where the law is
// stable with either reading of (23).
#include "measuring_steps.h"
#include "paper_a.h"
#include "scenario.h"

#include "testing.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstdio>
#include <functional>

using paper_a::Drive;
using paper_a::Estimator;
using paper_a::Settings;
using paper_a::turned;
using paper_a::TWO_PI;
using paper_a::Vector;

namespace
{

constexpr double RAD_S_PER_RPM = TWO_PI / 60 * 2;
constexpr double RATED_RAD_S = 1800 * RAD_S_PER_RPM;
constexpr double DEG = 360 / TWO_PI;

// ---- figures of S1 to S3 ----

struct Figures {
    double speed_rpm; // largest |ω − ω̂|
    double angle_deg; // largest |θ − θ̂|, electrical
};

// One sample at a time of the scenario.
using Script = std::function<void(Drive &, double time_s)>;

// Judged is from judged_from_s to the end at to_s; the last rest_s of it the rotor rests. There an
// offset δ of i_q is a speed error of δ·R/φ, and nothing corrects the angle.
struct Course {
    double from_s;
    double judged_from_s;
    double to_s;
    double rest_s;
};

Figures largest_errors(const Settings &s, const Script &script, const Course &course)
{
    Drive drive(s);
    Figures f{0, 0};
    const auto at = [&](double time_s) { return std::llround(time_s / s.period); };
    for (int64_t k = at(course.from_s); k < at(course.to_s); k++) {
        const double speed_error = drive.machine.speed() - drive.estimator.speed;
        const double angle_error = drive.machine.angle() - drive.estimator.angle;
        if (k >= at(course.judged_from_s)) {
            f.speed_rpm = std::max(f.speed_rpm, std::abs(speed_error) / RAD_S_PER_RPM);
            f.angle_deg =
                std::max(f.angle_deg, std::abs(std::remainder(angle_error, TWO_PI)) * DEG);
        }
        script(drive, static_cast<double>(k) * s.period + s.period / 2);
    }
    return f;
}

constexpr Course S1 = {0, 0, 1.0, 0};

void s1(Drive &drive, double time_s)
{
    const double rpm = time_s < 0.2 ? 0 : (time_s < 0.6 ? 1000 : 1800);
    drive.follow_speed(rpm * RAD_S_PER_RPM, 0);
}

void s2(Drive &drive, double time_s)
{
    const bool loaded = time_s > 0.5 && time_s < 0.8;
    drive.follow_speed(time_s < -0.7 ? 0 : RATED_RAD_S, loaded ? 3 : 0);
}

void s3(Drive &drive, double time_s)
{
    const double turns = time_s < 0.3 ? 0 : (time_s < 1.0 ? 1.5 : -1.5);
    drive.follow_position(turns * TWO_PI * 2, 0);
}

// States of the estimator off their steady values: x, y, ω̂, its value taken, θ̂, θ̂ before.
using Deviation = Eigen::Matrix<double, 6, 1>;
using Map = Eigen::Matrix<double, 6, 6>;

// One sample beside a motor without current that turns at a constant speed.
Deviation after_a_sample(const Settings &s, double speed, const Deviation &off,
                         const Vector &current)
{
    const double turn = speed * s.period;
    Estimator e(s);
    e.network += off.head<2>();
    e.speed = speed + off(2);
    e.speed_taken = speed + off(3);
    e.angle = off(4);
    e.angle_before = off(5) - turn;
    e.step(s, current, turned(Vector(0, speed * s.flux), -turn / 2));
    Deviation next;
    next << e.network - Vector(s.flux_current(), 0), e.speed - speed, e.speed_taken - speed,
        e.angle - turn, e.angle_before;
    return next;
}

// Small enough for products of two deviations to vanish, large against the rounding of the states.
constexpr double OFF = 1e-6;

Map linear_map(const Settings &s, double speed)
{
    const Deviation rest = after_a_sample(s, speed, Deviation::Zero(), Vector::Zero());
    Map map;
    for (int n = 0; n < 6; n++) {
        map.col(n) =
            (after_a_sample(s, speed, Deviation::Unit(n) * OFF, Vector::Zero()) - rest) / OFF;
    }
    return map;
}

// What white noise of 1 A rms in each axis makes of ω̂ and θ̂, rms.
Eigen::Vector2d noise_of_estimate(const Settings &s, double speed)
{
    const Map map = linear_map(s, speed);
    const Deviation rest = after_a_sample(s, speed, Deviation::Zero(), Vector::Zero());
    Eigen::Vector2d squares(0, 0);
    for (const Vector &axis : {Vector(OFF, 0), Vector(0, OFF)}) {
        Deviation response = (after_a_sample(s, speed, Deviation::Zero(), axis) - rest) / OFF;
        for (int k = 0; k < 2000; k++) { // some 18 times 1/90 s
            squares += Eigen::Vector2d(response(2), response(4)).cwiseAbs2();
            response = map * response;
        }
    }
    return squares.cwiseSqrt();
}

constexpr int CONVERTER_BITS = 14; // 12 on the bench, whose steps are 20 % of these figures

constexpr int RUNS = 8;                 // their mean spreads by a tenth of the tolerance
constexpr double OTHER_ROUNDING = 1e-6; // of the flux: far below a step of the converter

// A largest error has rounding noise in it: the mean over runs that differ in nothing else.
Figures largest_errors_of_firmware(const char *name)
{
    Figures mean = {0, 0};
    for (int k = 0; k < RUNS; k++) {
        const nf::Config config =
            nf::load_scenario(name, {},
                              {"board.adc_bits=" + std::to_string(CONVERTER_BITS),
                               "plant.flux_scale=" + std::to_string(1 + k * OTHER_ROUNDING)});
        const nf::MetricValues m = nf::run_scenario(config).metrics;
        mean.speed_rpm += m.speed_error_max_rpm.value_or(HUGE_VAL) / RUNS;
        mean.angle_deg += m.angle_error_max_deg.value_or(HUGE_VAL) / RUNS;
    }
    return mean;
}

void compare(const char *name, const Script &script, const Course &course)
{
    const nf::Config config =
        nf::load_scenario(name, {}, {"board.adc_bits=" + std::to_string(CONVERTER_BITS)});
    const Figures firmware = largest_errors_of_firmware(name);
    const Settings s;
    const Figures paper = largest_errors(s, script, course);
    const nf::reference::MeasuringSteps steps(config.board.current_full_scale_a, CONVERTER_BITS);
    const Eigen::Vector2d noise =
        nf::reference::LARGEST_OF_MANY * steps.noise() * noise_of_estimate(s, RATED_RAD_S);
    const double drift = steps.offset() * s.resistance / s.flux * course.rest_s;
    const Figures tolerance = {noise(0) / RAD_S_PER_RPM, (noise(1) + drift) * DEG};

    std::printf("%s: %.3g rpm, paper %.3g ± %.2g; %.3g°, paper %.3g ± %.2g\n", name,
                firmware.speed_rpm, paper.speed_rpm, tolerance.speed_rpm, firmware.angle_deg,
                paper.angle_deg, tolerance.angle_deg);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance.speed_rpm, paper.speed_rpm, firmware.speed_rpm);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance.angle_deg, paper.angle_deg, firmware.angle_deg);
}

TEST(test_errors_of_the_published_tuning_are_those_of_the_paper)
{
    compare("s1", s1, S1);
    compare("s2", s2, {-0.8, 0.1, 1.0, 0});
    compare("s3", s3, {0, 0, 1.7, 0.35});
}

// ---- stability ----

// Growth of the mode that grows most, or decays least, 1/s. At standstill the angle is not seen: an
// error of it stays.
double growth(const Settings &s, double speed)
{
    const Eigen::EigenSolver<Map> solver(linear_map(s, speed), false);
    double largest = 0;
    for (const auto &value : solver.eigenvalues()) {
        const bool stays = speed <= 0 && value.imag() == 0;
        largest = stays ? largest : std::max(largest, std::abs(value));
    }
    return std::log(largest) / s.period;
}

Settings settings(double kappa, bool newer_speed)
{
    Settings s;
    s.kappa = kappa;
    s.newer_speed = newer_speed;
    return s;
}

// T/τ
double decay()
{
    return Settings().period * Settings().resistance / Settings().inductance;
}

// The κ between two at which the growth changes its sign.
double limit_of_stability(double low, double high, bool newer_speed, double speed)
{
    const bool grows_low = growth(settings(low, newer_speed), speed) > 0;
    TEST_ASSERT_TRUE(grows_low != (growth(settings(high, newer_speed), speed) > 0));
    for (int n = 0; n < 40; n++) {
        const double middle = (low + high) / 2;
        const bool same = (growth(settings(middle, newer_speed), speed) > 0) == grows_low;
        low = same ? middle : low;
        high = same ? high : middle;
    }
    return low;
}

// At standstill e_q and ω̂ are a system of their own. With δ = T/τ its determinant is 1 − δ with the
// newer speed, and 1 − δ + κ with the printed one: the swing decays by the winding alone, or grows.
// With speed the forward difference of (14) stretches by (ωT)²/2 in a sample, and coupling to the
// angle is of the same order.
TEST(test_swing_decays_by_the_winding_with_the_newer_speed_and_grows_with_the_printed_one)
{
    const double kappa = 0.025;
    const double period = Settings().period;
    const double newer = std::log(1 - decay()) / (2 * period);           // −92/s
    const double printed = std::log(1 - decay() + kappa) / (2 * period); // 33/s
    const double rounding = OFF / period;                                // of linear_map

    TEST_ASSERT_DOUBLE_WITHIN(rounding, newer, growth(settings(kappa, true), 0));
    TEST_ASSERT_DOUBLE_WITHIN(rounding, printed, growth(settings(kappa, false), 0));
    for (const double speed : {0.1 * RATED_RAD_S, 0.5 * RATED_RAD_S, RATED_RAD_S}) {
        const double turn = speed * period;
        const double order = turn * turn / period;
        TEST_ASSERT_DOUBLE_WITHIN(order, printed, growth(settings(kappa, false), speed));
        TEST_ASSERT_TRUE(growth(settings(kappa, true), speed) < 0);
    }
}

TEST(test_printed_index_is_stable_up_to_a_kappa_of_t_over_tau)
{
    for (const double speed : {0.0, 0.1 * RATED_RAD_S, 0.5 * RATED_RAD_S, RATED_RAD_S}) {
        const double turn = speed * Settings().period;
        const double limit = limit_of_stability(0.01, 0.03, false, speed);
        TEST_ASSERT_DOUBLE_WITHIN(turn * turn + OFF, decay(), limit);
    }
}

// A small error in continuous time, with a = 1/τ and K = κ/T²: s⁴ + 2a·s³ + (a² + ω² + K)·s² + Ka·s
// + Kω² = 0. After Routh it is stable for K > 2(ω² − a²). Sampling adds terms that are by ωT and
// T/τ smaller.
TEST(test_a_kappa_without_proportional_path_has_a_lower_limit_that_grows_with_speed)
{
    for (const double speed : {0.8 * RATED_RAD_S, RATED_RAD_S, 1.5 * RATED_RAD_S}) {
        const double turn = speed * Settings().period;
        const double expected = 2 * (turn * turn - decay() * decay());
        const double next_order = 2 * turn * turn * (turn + decay());
        for (const bool newer : {true, false}) {
            const double limit = limit_of_stability(expected / 2, 0.012, newer, speed);
            std::printf("%.0f rad/s: least kappa %.5f, expected %.5f ± %.5f\n", speed, limit,
                        expected, next_order);
            TEST_ASSERT_DOUBLE_WITHIN(next_order, expected, limit);
        }
    }
}

// In the drive, κ = 0.025: with the printed index it runs away at the first step of the speed; else
// it has a quarter of a degree.
TEST(test_drive_with_the_printed_index_loses_the_rotor)
{
    TEST_ASSERT_TRUE(largest_errors(settings(0.025, false), s1, S1).angle_deg > 90);
    TEST_ASSERT_TRUE(largest_errors(settings(0.025, true), s1, S1).angle_deg < 1);
}

} // namespace
