// SPDX-License-Identifier: MIT
// Torque filter beside its twin, and its frequency response beside that of the design.
#include "settings_under_test.h"
#include "torque_filter_units.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::TWO_PI;

namespace
{

using Complex = std::complex<double>;

constexpr double Q26_LSB = 1.0 / 2048; // of a current's LSB
constexpr double RATE_HZ = 1000;
constexpr double LEAST_SHARE = 0.05; // the bounds add up roundings that mostly cancel
constexpr int32_t CURRENT_MAX = 16384;

nf::TuningSettings tuning_of(double notch_hz, double width_pct, double low_pass_hz)
{
    nf::TuningSettings tuning = nf::reference::tuning();
    tuning.notch_hz = notch_hz;
    tuning.notch_width_pct = width_pct;
    tuning.torque_filter_hz = low_pass_hz;
    return tuning;
}

torque_filter_cfg_t cfg_of(const nf::TuningSettings &tuning)
{
    return nf::make_torque_filter(tuning,
                                  nf::make_bases(nf::reference::motor_a(), nf::reference::board()));
}

const std::vector<nf::TuningSettings> EXAMPLES = {
    tuning_of(0, 50, 100),  tuning_of(100, 50, 0),  tuning_of(25, 30, 0),
    tuning_of(240, 100, 0), tuning_of(450, 30, 80), tuning_of(60, 70, 40),
};

// A sample rounds each part of the swing by up to 8 LSB of Q26 (two products of the turn, one of
// the share; each down, and doubled), together √2·8. The turn keeps the length, and the share takes
// √(1 − μ) of the part along d: a rounding fades within 1/(1 − √(1 − μ)) samples. The low-pass adds
// 2 LSB a sample, which fade by r. The result is rounded to nearest.
double bound_lsb(const torque_filter_cfg_t &cfg)
{
    const double mu = cfg.notch_share_q15 / Q15;
    const double r = cfg.smooth_rate_q15 / Q15;
    const double notch = mu > 0 ? std::sqrt(2.0) * 8 / (1 - std::sqrt(1 - mu)) + 1 : 0;
    const double low_pass = r > 0 ? 2 / r : 0;
    // A notch lets its input's error through, at most twice.
    return 0.5 + (notch + 2 * low_pass) * Q26_LSB;
}

// Steps, a swing and noise.
TEST(test_currents_stay_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 20000;
    double worst = 0;
    Seeded seeded(3);
    for (const nf::TuningSettings &tuning : EXAMPLES) {
        const torque_filter_cfg_t cfg = cfg_of(tuning);
        const int32_t start = seeded.in(-CURRENT_MAX, CURRENT_MAX);
        torque_filter_t filter;
        nf::twin::TorqueFilter twin(nf::twin::torque_filter_params(cfg));
        torque_filter_start(&filter, start);
        twin.start(start);
        double largest = 0;
        for (int k = 0; k < STEPS; k++) {
            const int32_t base = (k / 700) % 2 == 0 ? 6000 : -6000;
            const double swing = 5000 * std::cos(TWO_PI * 0.09 * k);
            const int32_t current =
                base + static_cast<int32_t>(std::lround(swing)) + seeded.in(-5000, 5000);
            const double exact = twin.step(current);
            largest =
                std::max(largest, std::abs(torque_filter_step(&filter, &cfg, current) - exact));
        }
        worst = std::max(worst, largest / bound_lsb(cfg));
    }
    figure_check("torque filter beside its twin, of its bound", worst, 1, LEAST_SHARE);
}

// What the filter makes of a swing of `hz`: gain and phase.
Complex measured(const torque_filter_cfg_t &cfg, double hz)
{
    constexpr int SETTLED = 4000;
    constexpr int SAMPLES = 10000;
    constexpr double AMPLITUDE = 10000;
    torque_filter_t filter;
    Complex sum = 0;
    torque_filter_start(&filter, 0);
    for (int k = 0; k < SETTLED + SAMPLES; k++) {
        const double turn = TWO_PI * hz / RATE_HZ * k;
        const auto current = static_cast<int32_t>(std::lround(AMPLITUDE * std::cos(turn)));
        const int32_t result = torque_filter_step(&filter, &cfg, current);
        sum += k < SETTLED ? 0.0 : static_cast<double>(result) * std::polar(1.0, -turn);
    }
    return sum * (2 / AMPLITUDE / SAMPLES);
}

// Sine, cosine and shares are rounded to half of 2^-15. A notch of a band of b Hz moves by less
// than 2^-15 rad of its 2π·b/f_s then, here 2^-15/0.047 at worst, and changes by as much; the
// low-pass by 2^-16 of its r, 2^-16/0.22. The results' own roundings average out. A thousandth
// holds all of it.
constexpr double RESPONSE = 1e-3;

TEST(test_the_response_is_that_of_the_design)
{
    for (const nf::TuningSettings &tuning : EXAMPLES) {
        const torque_filter_cfg_t cfg = cfg_of(tuning);
        for (const double hz : {3.0, 12.0, 25.0, 60.0, 95.0, 100.0, 240.0, 333.0, 450.0}) {
            const Complex exact = nf::torque_filter_response(tuning, RATE_HZ, hz);
            const Complex found = measured(cfg, hz);
            TEST_ASSERT_DOUBLE_WITHIN(RESPONSE, 0, std::abs(found - exact));
        }
    }
}

// A design by other formulas: an analogue notch (s² + ω²)/(s² + k·ω·s + ω²) by the bilinear
// transform with the tangent of half of the centre's turn, k by that of the band.
TEST(test_the_design_is_the_analogue_notch_through_the_bilinear_transform)
{
    for (const double notch_hz : {25.0, 100.0, 240.0, 450.0}) {
        const nf::TuningSettings tuning = tuning_of(notch_hz, 30, 0);
        const double centre = std::tan(TWO_PI / 2 * notch_hz / RATE_HZ);
        // At the edges |x − 1/x| = k in units of the centre; the edges' turns differ by the band's.
        const double band = std::tan(TWO_PI / 2 * notch_hz * 0.3 / RATE_HZ);
        const double k = band * (1 + centre * centre) / centre;
        for (const double hz : {1.0, 20.0, 90.0, 200.0, 400.0, 499.0}) {
            const Complex s(0, std::tan(TWO_PI / 2 * hz / RATE_HZ) / centre);
            const Complex analogue = (s * s + 1.0) / (s * s + k * s + 1.0);
            const Complex digital = nf::torque_filter_response(tuning, RATE_HZ, hz);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, std::abs(digital - analogue));
        }
    }
}

} // namespace
