// SPDX-License-Identifier: MIT
// Each estimator beside an ideal motor, and the place that it takes in the drive.
#include "measuring_steps.h"
#include "neural.h"
#include "peer.h"
#include "replace.h"

#include "testing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>

#include <unistd.h>

using nf::peers::all;
using nf::peers::Complex;
using nf::peers::Estimate;
using nf::peers::J;
using nf::peers::Model;
using nf::peers::Peer;
using nf::peers::turn;

namespace
{

constexpr double TWO_PI = 6.283185307179586476925;

// Motors A and B of the scenarios.
const Model MOTOR_A = {1e-4, 2.125, 0.0116, 0.0116, 0.387, 18.8, 524};
const Model MOTOR_B = {1e-4, 0.405, 0.0135, 0.0235, 0.375, 12.6, 367};

// A motor at an imposed speed. The voltage stands still in each period and is that of the current
// wanted in its middle.
struct Motor {
    const Model &m;
    double speed;
    Complex current; // i_d + j·i_q
    double angle = 0;

    Complex steady_voltage() const
    {
        const Complex flux(m.inductance_d_h * current.real() + m.flux_wb,
                           m.inductance_q_h * current.imag());
        return m.resistance_ohm * current + J * speed * flux;
    }

    Complex derivative(Complex i, Complex voltage, double at) const
    {
        const Complex flux(m.inductance_d_h * i.real() + m.flux_wb, m.inductance_q_h * i.imag());
        const Complex change = voltage * turn(-at) - m.resistance_ohm * i - J * speed * flux;
        return {change.real() / m.inductance_d_h, change.imag() / m.inductance_q_h};
    }

    // A period, by Runge and Kutta.
    void run(Complex voltage)
    {
        constexpr int STEPS = 8;
        const double h = m.period_s / STEPS;
        for (int n = 0; n < STEPS; n++) {
            const Complex a = derivative(current, voltage, angle);
            const Complex b = derivative(current + h / 2 * a, voltage, angle + h / 2 * speed);
            const Complex c = derivative(current + h / 2 * b, voltage, angle + h / 2 * speed);
            const Complex d = derivative(current + h * c, voltage, angle + h * speed);
            current += h / 6 * (a + 2.0 * b + 2.0 * c + d);
            angle += h * speed;
        }
    }
};

struct Errors {
    double angle_rad;
    double speed_rad_s;
};

// What an estimator makes of the motor from an estimate that is `off` at first, after `settle`
// samples of `samples`: its largest errors. Each axis of the current has white noise.
struct Trial {
    double speed;
    double current_q;
    Estimate off;
    double noise_a;
    int settle;
    int samples;
};

Errors largest_errors(nf::peers::Estimator &estimator, const Model &m, const Trial &trial)
{
    Motor motor{m, trial.speed, Complex(0, trial.current_q)};
    const Complex wanted = motor.steady_voltage();
    const double advance = trial.speed * m.period_s;
    std::mt19937 generator(1); // NOLINT: the same noise in each run
    const auto deviate = [&] {
        const double share = static_cast<double>(generator()) / 4294967296.0 - 0.5;
        return std::sqrt(12.0) * trial.noise_a * share;
    };
    Errors worst{0, 0};
    estimator.start(m, {advance + trial.off.angle_rad, trial.speed + trial.off.speed_rad_s},
                    motor.current);
    for (int k = 0; k < trial.samples; k++) {
        const Complex voltage = wanted * turn(motor.angle + advance / 2);
        motor.run(voltage);
        const double noise_alpha = deviate();
        const Complex noise(noise_alpha, deviate());
        const Estimate next =
            estimator.step(m, {motor.current * turn(motor.angle) + noise, voltage, trial.speed});
        const double angle = motor.angle + advance - next.angle_rad;
        if (k >= trial.settle) {
            worst.angle_rad = std::max(worst.angle_rad, std::abs(std::remainder(angle, TWO_PI)));
            worst.speed_rad_s =
                std::max(worst.speed_rad_s, std::abs(trial.speed - next.speed_rad_s));
        }
    }
    return worst;
}

// From an eighth of a turn and a fifth of the speed off. The estimators let the EMF act in the
// middle of a period, and the resistance with one current. That turns the EMF by ωT·(T/τ)/12, and
// the drop moves it by as much again at most where R·i is below the EMF. An angle that wrong, with
// the current's ripple, is a speed that wrong within the fastest settling, 10 ms.
TEST(test_each_estimator_finds_speed_and_angle_of_an_ideal_motor)
{
    for (const Peer &peer : all()) {
        for (const Model *m : {&MOTOR_A, &MOTOR_B}) {
            const double decay = m->period_s * m->resistance_ohm / m->inductance_d_h;
            for (const double share : {0.2, 1.0, -1.0}) {
                const double speed = share * m->speed_limit_rad_s / 1.25;
                const double bound = 2 * std::abs(speed) * m->period_s * decay / 12;
                for (const double current : {0.0, 4.0}) {
                    const auto tuned = nf::peers::load("a test", peer.name);
                    const Errors e =
                        largest_errors(*tuned.estimator, *m,
                                       {speed, current, {TWO_PI / 8, -speed / 5}, 0, 19000, 20000});
                    std::printf("%-12s %6.1f rad/s %g A: %.2g rad, %.2g rad/s, bound %.2g rad\n",
                                peer.name, speed, current, e.angle_rad, e.speed_rad_s, bound);
                    TEST_ASSERT_TRUE_MESSAGE(e.angle_rad <= bound, peer.name);
                    TEST_ASSERT_TRUE_MESSAGE(e.speed_rad_s <= bound / 0.01, peer.name);
                }
            }
        }
    }
}

// ---- in the drive ----

struct Figures {
    double speed_rpm;
    double angle_deg;
};

Figures figures_of(const nf::Config &config, std::unique_ptr<nf::peers::Estimator> estimator)
{
    nf::RunOptions options;
    if (estimator) {
        options.estimate = nf::peers::in_place_of_the_observer(config, std::move(estimator));
    }
    const nf::RunResult result = nf::run_scenario(config, options);
    TEST_ASSERT_TRUE(result.metrics.locked);
    return {result.metrics.speed_error_max_rpm.value_or(HUGE_VAL),
            result.metrics.angle_error_max_deg.value_or(HUGE_VAL)};
}

std::unique_ptr<nf::peers::Estimator> as_the_drive(const nf::Config &config)
{
    const nf::TuningSettings &tuning = config.tuning;
    return std::make_unique<nf::peers::Neural>(
        nf::peers::Neural::Gains{tuning.observer_kappa, tuning.observer_kappa_p,
                                 tuning.observer_rho_max, tuning.observer_feedback});
}

double bandwidth_hz(const nf::Config &config)
{
    return nf::settled_tuning(config.motor, config.board, config.tuning, config.model)
        .speed_bandwidth_hz;
}

// The drive's own observer in double precision with the same gains at every speed, in its own
// place: the place is fair. The speed loop reads the speed a tick later there, which is 2πf·T of a
// figure in a transient. Else what differs is the roundings of both runs: as noise, and as an
// offset. The drive rounds the current error down, by up to a step of its signals in each axis,
// which turns the angle by (1 + ρ)·L/φ times the step.
TEST(test_the_drives_own_law_in_that_place_gives_the_drives_own_figures)
{
    constexpr int BITS = 14;
    const std::pair<const char *, const char *> runs[] = {
        {"s1_robust", "0"}, {"s2_robust", "0"}, {"s2_robust", "0.08"}};
    for (const auto &[name, feedback] : runs) {
        const nf::Config config = nf::load_scenario(
            name, {},
            {"board.adc_bits=" + std::to_string(BITS), "observer.acceleration_feed_forward=0",
             "observer.pace_speed_pct=0", "observer.kappa_speed_pct=0",
             std::string("observer.feedback=") + feedback});
        const nf::reference::MeasuringSteps steps(config.board.current_full_scale_a, BITS);
        const Errors noise =
            largest_errors(*as_the_drive(config), MOTOR_A,
                           {377, 0, {0, 0}, std::sqrt(2.0) * steps.noise(), 1000, 11000});
        const Figures own = figures_of(config, nullptr);
        const Figures other = figures_of(config, as_the_drive(config));
        const double later = TWO_PI * bandwidth_hz(config) / config.board.pwm_frequency_hz;
        const double rpm =
            noise.speed_rad_s * 60 / TWO_PI / config.motor.pole_pairs + later * own.speed_rpm;
        const double offset_rad = steps.signal * (1 + config.tuning.observer_rho_max) *
                                  MOTOR_A.inductance_d_h / MOTOR_A.flux_wb;
        const double deg = (noise.angle_rad + offset_rad) * 360 / TWO_PI + later * own.angle_deg;

        std::printf("%s: %.4g and %.4g rpm ± %.2g; %.4g and %.4g° ± %.2g\n", name, own.speed_rpm,
                    other.speed_rpm, rpm, own.angle_deg, other.angle_deg, deg);
        TEST_ASSERT_DOUBLE_WITHIN(rpm, own.speed_rpm, other.speed_rpm);
        TEST_ASSERT_DOUBLE_WITHIN(deg, own.angle_deg, other.angle_deg);
    }
}

// All that the drive does with an estimate, from the start of a rotor at any angle to the position
// loop. With noise some lose the rotor in S3.
TEST(test_each_estimator_serves_the_drive)
{
    const std::pair<const char *, const char *> runs[] = {{"s1_robust", "all"},
                                                          {"s3_robust", "ideal"}};
    for (const Peer &peer : all()) {
        for (const auto &[name, set] : runs) {
            const nf::Config config = nf::load_scenario(name, {set});
            const Figures f = figures_of(config, nf::peers::load("a test", peer.name).estimator);
            std::printf("%-12s %s %s: %.3g rpm, %.3g°\n", peer.name, name, set, f.speed_rpm,
                        f.angle_deg);
        }
    }
}

TEST(test_a_sensor_leaves_nothing_to_estimate)
{
    const nf::Config config = nf::load_scenario("s4");
    try {
        nf::peers::in_place_of_the_observer(config, as_the_drive(config));
        TEST_FAIL_MESSAGE("taken");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING("--estimator: drive.angle_source = \"sensor\": leaves nothing to "
                                 "estimate; allowed: \"observer\"",
                                 error.what());
    }
}

// ---- files of gains ----

void expect_refusal(const std::string &text, const std::string &message)
{
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("gains_" + std::to_string(getpid()) + ".toml");
    std::ofstream(path) << text;
    std::string found = "taken";
    try {
        nf::peers::load("--estimator", path.string());
    } catch (const nf::ConfigError &error) {
        found = error.what();
    }
    std::filesystem::remove(path);

    TEST_ASSERT_EQUAL_STRING((path.string() + message).c_str(), found.c_str());
}

TEST(test_a_wrong_file_is_named_with_its_line_and_what_is_allowed)
{
    const std::string kinds = "luenberger, sliding_mode, flux, kalman, neural";
    const std::string head = "estimator = \"neural\"\n[gain]\nkappa = 0.025\nkappa_p = 0.4\n";
    expect_refusal("gain.kappa = 1\n", ":1: estimator: is missing; allowed: " + kinds);
    expect_refusal("estimator = \"ekf\"\n",
                   ":1: estimator = \"ekf\": is no estimator; allowed: " + kinds);
    expect_refusal("estimator = 3\n", ":1: estimator = 3: is no estimator; allowed: " + kinds);
    expect_refusal("estimator = \"neural\"\n", ":1: gain: is missing; allowed: a table");
    expect_refusal("estimator = \"neural\"\ngain = 2\n",
                   ":2: gain = 2: is a whole number; allowed: a table");
    expect_refusal(head, ":2: gain.rho_max: is missing; allowed: 0.01 to 10");
    expect_refusal(head + "rho_max = 20\n",
                   ":5: gain.rho_max = 20: is too large; allowed: 0.01 to 10");
    expect_refusal(
        head + "rho_max = 2\nkapa = 1\n",
        ":6: kapa = 1: unknown gain, did you mean kappa?; allowed: kappa, kappa_p, rho_max");
    expect_refusal(head + "rho_max = 2\n[gains]\n",
                   ":6: gains = {…}: unknown key, did you mean gain?; allowed: estimator, gain");
}

} // namespace
