// SPDX-License-Identifier: MIT
// Modulator beside its twin: from a voltage in the rotor frame to three duties.
#include "firmware.h"
#include "settings_under_test.h"
#include "twin_modulator.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;
using nf::twin::Vector;

// Phase-to-phase, in LSB of Q15 of the bus, for a ratio r ≤ 1/√3 of the bus:
//   reciprocal settled to 1.5/4096 of it, √3 of r between phases: 1.5/4096·32768          12.0
//   ratio rounded down in d and q, 1 LSB each: √2, √3 of it between phases                  2.45
//   inverse Park: sincos 0.773·√2·r, amplitude r, rounding ½ in α and β: ½·√2, times √3     3.4
//   β·√3/2 and α/2 rounded down                                                             2.2
//   counts rounded to nearest, twice ½                                   32768/timer_counts: 3.9
// A vector at the limit may reach beyond the rails by as much and is cut: not more than the sum
// again.
static constexpr double RATIO_LSB = 12.0 + 2.45 + 3.4 + 2.2;
static constexpr double LEAST_SHARE = 0.3;

static compare_t compared(const modulator_t &mod, const modulator_cfg_t &cfg, ab_t ratio,
                          ab_t current)
{
    compare_t out;
    modulator_compare_compensated(&mod, &cfg, ratio, current, &out);
    return out;
}

static double line_difference(const Eigen::Vector3d &a, const Eigen::Vector3d &b)
{
    double worst = 0;
    for (int p = 0; p < 3; p++) {
        const int n = (p + 1) % 3;
        worst = std::max(worst, std::abs((a(p) - a(n)) - (b(p) - b(n))));
    }
    return worst;
}

TEST(test_duties_of_a_settled_bus_stay_within_the_roundings_of_the_twin)
{
    const nf::reference::Setup s(nf::reference::motor_a(), nf::reference::board(),
                                 nf::reference::tuning());
    const modulator_cfg_t &cfg = s.cfg.modulator;
    const double counts_lsb = Q15 / cfg.timer_counts;
    Seeded seeded(1);
    double worst = 0;

    for (int run = 0; run < 300; run++) {
        const int32_t bus = seeded.in(14564, 29127); // 200…400 V
        const int32_t limit = modulator_limit(&cfg, bus);
        modulator_t mod;

        modulator_reset(&mod, &cfg);
        for (int k = 0; k < 12; k++) {
            modulator_track_bus(&mod, bus);
        }
        for (int k = 0; k < 300; k++) {
            const double direction = seeded.in(0, 1 << 20) * TWO_PI / (1 << 20);
            const double radius = (k % 2 == 0) ? limit : seeded.in(0, limit);
            const dq_t v = {static_cast<int32_t>(radius * std::cos(direction)),
                            static_cast<int32_t>(radius * std::sin(direction))};
            const auto angle = static_cast<angle_t>(seeded.in(INT32_MIN, INT32_MAX));
            const dq_t ratio = modulator_ratio(&mod, v);
            const compare_t c =
                compared(mod, cfg, transforms_park_inverse(ratio, trig_sincos(angle)), ab_t{0, 0});
            const Vector volt =
                nf::twin::park_inverse(s.voltage(v), angle / STEPS_PER_TURN * TWO_PI);
            const Eigen::Vector3d exact = nf::twin::Modulator::duties(volt, s.voltage(bus));
            const Eigen::Vector3d duty =
                Eigen::Vector3d(c.phase[0], c.phase[1], c.phase[2]) / cfg.timer_counts;

            TEST_ASSERT_TRUE(volt.norm() <= nf::twin::Modulator::reach(s.voltage(bus)));
            worst = std::max(worst, line_difference(duty, exact) * Q15);
        }
    }
    figure_check("phase-to-phase duty beside its twin, LSB of Q15", worst, RATIO_LSB + counts_lsb,
                 LEAST_SHARE);
}

TEST(test_too_long_vectors_are_cut_like_the_twin)
{
    // No bus in it: a ratio beyond the hexagon, |α|, |β| ≤ 1, each duty cut at 0 and 1.
    // β·√3/2 rounded down 1.1, α/2 0.5, half the sum 1.05: 2.65 of Q15; counts ½. Where
    // it is cut, duty one is 1 of Q15 short and nothing else.
    const nf::reference::Setup s(nf::reference::motor_a(), nf::reference::board(),
                                 nf::reference::tuning());
    const double bound = 2.65 + 0.5 * Q15 / s.cfg.modulator.timer_counts;
    Seeded seeded(2);
    modulator_t mod;
    double worst = 0;

    modulator_reset(&mod, &s.cfg.modulator);
    for (int k = 0; k < 100000; k++) {
        const ab_t ratio = {seeded.in(-32767, 32767), seeded.in(-32767, 32767)};
        const compare_t c = compared(mod, s.cfg.modulator, ratio, ab_t{0, 0});
        const Eigen::Vector3d exact =
            nf::twin::Modulator::duties(Vector(ratio.alpha, ratio.beta), Q15);
        const Eigen::Vector3d duty =
            Eigen::Vector3d(c.phase[0], c.phase[1], c.phase[2]) / s.cfg.modulator.timer_counts;

        worst = std::max(worst, (duty - exact).cwiseAbs().maxCoeff() * Q15);
    }
    figure_check("cut duties beside their twin, LSB of Q15", worst, bound, LEAST_SHARE);
}

// Dead-time compensation beside its twin, LSB of Q15 of the duty. Phases of ratio and current are
// rounded down, PHASE_LSB.
//   crossing  s twice the phase, and 9·u²: 2·u, rounded down  2·1.6 + 9·(2·u·1.6 + 1)
//   ripple    its own share of that, rounded down             ripple·crossing + 1
//   share     z·(2 − z) has twice the edge's slope at most, times the errors of ripple and of the
//             current, rounded down
//   loss      drop times the reciprocal of the bus, which is settled to 1.5/4096, rounded down
//   duty      rounded down; counts rounded to nearest
// The twin is as steep at most, so that a sign that differs near zero counts no more.
static constexpr double PHASE_LSB = 1.6;
static constexpr double LONGEST_RATIO = 0.577;

TEST(test_dead_time_given_back_stays_within_the_roundings_of_the_twin)
{
    nf::ModelScales losses;
    losses.dead_time_s = 2e-6;
    losses.device_drop_v = 1.2;
    const nf::reference::Setup s(nf::reference::motor_a(), nf::reference::board(),
                                 nf::reference::tuning());
    const modulator_cfg_t cfg = nf::make_drive_cfg(nf::reference::motor_a(), nf::reference::board(),
                                                   nf::reference::tuning(), losses)
                                    .modulator;
    const int32_t bus = 22573; // 310 V
    const double bus_v = s.voltage(bus);
    const nf::twin::Modulator::Losses twin = {cfg.dead_time_q15 / Q15, s.voltage(cfg.drop_q15),
                                              s.current(cfg.ripple_q15),
                                              cfg.edge_slope / s.current(Q15)};
    const double loss = (twin.dead_time_share + twin.drop_v / bus_v) * Q15;
    const double crossing = 2 * PHASE_LSB + 9 * (2 * LONGEST_RATIO * PHASE_LSB + 1);
    const double ripple = crossing * cfg.ripple_q15 / Q15 + 1;
    const double share = 2 * cfg.edge_slope * (ripple + PHASE_LSB) / Q15;
    const double of_loss = cfg.drop_q15 * 1.5 / 4096 + 1;
    const double bound = share * loss + of_loss + 2 + PHASE_LSB + 0.5 * Q15 / cfg.timer_counts;
    Seeded seeded(3);
    modulator_t mod;
    double worst = 0;

    modulator_reset(&mod, &cfg);
    for (int k = 0; k < 12; k++) {
        modulator_track_bus(&mod, bus);
    }
    for (int k = 0; k < 100000; k++) {
        const double direction = seeded.in(0, 1 << 20) * TWO_PI / (1 << 20);
        const double radius = seeded.in(0, 16000);
        const double ahead = seeded.in(0, 1 << 20) * TWO_PI / (1 << 20);
        const double size = seeded.in(0, (k % 2 == 0) ? 800 : 12000);
        const ab_t ratio = {static_cast<int32_t>(radius * std::cos(direction)),
                            static_cast<int32_t>(radius * std::sin(direction))};
        const ab_t current = {static_cast<int32_t>(size * std::cos(ahead)),
                              static_cast<int32_t>(size * std::sin(ahead))};
        const compare_t c = compared(mod, cfg, ratio, current);
        const Vector volt = Vector(ratio.alpha, ratio.beta) / Q15 * bus_v;
        const Vector ampere(s.current(current.alpha), s.current(current.beta));
        const Eigen::Vector3d exact = nf::twin::Modulator::duties(volt, bus_v) +
                                      nf::twin::Modulator::compensation(twin, volt, bus_v, ampere);
        const Eigen::Vector3d duty =
            Eigen::Vector3d(c.phase[0], c.phase[1], c.phase[2]) / cfg.timer_counts;

        TEST_ASSERT_TRUE(exact.maxCoeff() < 1 && exact.minCoeff() > 0);
        worst = std::max(worst, (duty - exact).cwiseAbs().maxCoeff() * Q15);
    }
    figure_check("duties with dead-time compensation beside their twin, LSB of Q15", worst, bound,
                 LEAST_SHARE);
}
