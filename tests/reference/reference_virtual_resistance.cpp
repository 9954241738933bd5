// SPDX-License-Identifier: MIT
// Virtual resistance beside its twin, and what it is for: the damping of the currents' own mode.
#include "firmware.h"
#include "settings_under_test.h"
#include "twin_virtual_resistance.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>
#include <complex>

using nf::reference::motor_b;
using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::TWO_PI;
using nf::twin::Vector;

namespace
{

constexpr double Q30 = 1073741824.0;
constexpr double LEAST_SHARE = 0.2;

// In LSB. The mean m is rounded down to an LSB of current before the difference is taken, by f < 1.
// So its error obeys e' = (1 − r)·e + r·f: it stays below 1. The difference is then off by f − e,
// within ±1. The products are exact.
constexpr double MEAN_LSB = 1.0;

// Motor B's of the rule: 1.94 Ω, 66 periods.
const virtual_resistance_cfg_t CFG = {5645, 494};

nf::twin::VirtualResistance::Params twin_params()
{
    return {CFG.resistance_q15 / Q15, CFG.mean_rate_q15 / Q15};
}

// A vector that swings about a mean that jumps, with noise.
TEST(test_voltages_stay_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 20000;
    Seeded seeded(1);
    virtual_resistance_t res;
    nf::twin::VirtualResistance twin(twin_params());
    double worst = 0;
    double worst_mean = 0;

    virtual_resistance_start(&res, {1000, -2000});
    twin.start({1000, -2000});
    for (int k = 0; k < STEPS; k++) {
        const double turn = k * 0.025;
        const int32_t base = (k / 3000) % 2 == 0 ? 1000 : -3000;
        const dq_t current = {
            base + static_cast<int32_t>(std::lround(900 * std::cos(turn))) + seeded.in(-40, 40),
            -base - static_cast<int32_t>(std::lround(900 * std::sin(turn))) + seeded.in(-40, 40)};
        const dq_t v = virtual_resistance_step(&res, &CFG, current);
        const Vector exact = twin.step(Vector(current.d, current.q));
        const Vector mean = Vector(res.mean_q30.d, res.mean_q30.q) / (Q30 / Q15);

        worst = std::max(worst, (Vector(v.d, v.q) / Q15 - exact).cwiseAbs().maxCoeff());
        worst_mean = std::max(worst_mean, (mean - twin.mean()).cwiseAbs().maxCoeff());
    }
    figure_check("virtual resistance beside its twin, LSB of U_b", worst,
                 twin_params().resistance * MEAN_LSB, LEAST_SHARE);
    figure_check("its mean, LSB of I_b", worst_mean, MEAN_LSB, LEAST_SHARE);
}

using Complex = std::complex<double>;

// The mode nearest to −jω of (s + R/L + jω)·(s + a) + R_v/L·s = 0.
Complex own_mode(double omega, double winding, double virtual_rate, double mean_rate)
{
    const Complex j(0, 1);
    const Complex b = winding + j * omega + mean_rate + virtual_rate;
    const Complex c = mean_rate * (winding + j * omega);
    const Complex root = std::sqrt(b * b - 4.0 * c);
    const Complex one = (-b + root) / 2.0;
    const Complex other = (-b - root) / 2.0;
    return std::abs(one + j * omega) < std::abs(other + j * omega) ? one : other;
}

// How fast the mode decays in a round motor with the firmware's block, exact between the samples,
// 1/s. From 40 ms on: the mean's own mode has gone to 1/80 of the other by then.
double measured_decay(const virtual_resistance_cfg_t &cfg, double omega, double inductance,
                      double resistance, double volt, double ampere)
{
    constexpr double PERIOD = 1e-4;
    constexpr int FIRST = 400;
    constexpr int LAST = 800;
    virtual_resistance_t res;
    const Complex turn =
        std::exp(-(Complex(resistance / inductance, omega)) * PERIOD); // of the current in a period
    const Complex gain = (1.0 - turn) / Complex(resistance, omega * inductance);
    Complex current = 8.0;
    double first = 0;
    double last = 0;

    virtual_resistance_start(&res, {0, 0});
    for (int k = 0; k <= LAST; k++) {
        const auto d = static_cast<int32_t>(std::lround(current.real() / ampere * Q15));
        const auto q = static_cast<int32_t>(std::lround(current.imag() / ampere * Q15));
        const dq_t v = virtual_resistance_step(&res, &cfg, {d, q});
        first = k == FIRST ? std::abs(current) : first;
        last = std::abs(current);
        current = turn * current + gain * Complex(v.d, v.q) * (volt / Q30);
    }
    return std::log(first / last) / ((LAST - FIRST) * PERIOD);
}

// A voltage is that of the last sample: half a period late, which turns it by half of ω·T = 0.025
// rad. The last current is 180 LSB, so roundings make a hundredth of its logarithm. A twentieth
// holds both.
TEST(test_it_damps_the_currents_own_mode_as_the_equations_say)
{
    constexpr double SHARE = 0.05;
    const nf::MotorSettings motor = motor_b();
    const double volt = 450;
    const double ampere = 40;
    // A fifth of the rule's, so that the mode and the mean's own are far apart.
    const virtual_resistance_cfg_t cfg = {CFG.resistance_q15 / 5, CFG.mean_rate_q15};
    const double resistance = cfg.resistance_q15 / Q15 * volt / ampere;
    const double mean_rate = cfg.mean_rate_q15 / Q15 * 1e4;
    const double inductance = 2 / (1 / motor.inductance_d_h + 1 / motor.inductance_q_h);
    const double omega = motor.rated_speed_rpm / 60 * TWO_PI * motor.pole_pairs;
    const double winding = motor.resistance_ohm / inductance;
    const double damped = -own_mode(omega, winding, resistance / inductance, mean_rate).real();

    const double as_stated =
        winding + resistance / inductance * omega * omega / (omega * omega + mean_rate * mean_rate);

    TEST_ASSERT_TRUE(damped > 1.6 * winding);
    // The header's equation leaves out the square of R_v/(ωL), 0.09 of what it adds.
    TEST_ASSERT_DOUBLE_WITHIN(0.09 * damped, damped, as_stated);
    TEST_ASSERT_DOUBLE_WITHIN(
        SHARE * damped, damped,
        measured_decay(cfg, omega, inductance, motor.resistance_ohm, volt, ampere));
}

} // namespace
