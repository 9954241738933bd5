// SPDX-License-Identifier: MIT
// The bus current of whole runs: held at its limits, by the plant's own power.
#include "scenario.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

constexpr double LOAD_END_S = 1.8;
constexpr double SETTLED_S = 1.75; // the speed has gone down to where the limit carries the load
constexpr double BRAKED_S = 2.4;   // from it on
constexpr double WINDOW_S = 0.01;  // what a supply's filter and a fuse do not see is shorter

// Power at the motor over the bus: torque and copper. What the inductances hold cancels out within
// a window. Only in RUN: what an imposed current takes is known before, and the configuration is
// refused where that is beyond the limit.
class BusCurrent : public nf::TickSink
{
public:
    BusCurrent(const nf::Config &config)
        : resistance_(config.motor.resistance_ohm * config.plant.resistance_scale),
          window_(static_cast<std::size_t>(std::lround(WINDOW_S * config.board.pwm_frequency_hz)))
    {
    }

    void add(const nf::Tick &tick) override
    {
        const plant_view_t &t = tick.truth;
        const double copper = 1.5 * resistance_ * (t.i_d_a * t.i_d_a + t.i_q_a * t.i_q_a);
        const double now = tick.sim->drive().state == DRIVE_STATE_RUN
                               ? (t.torque_nm * t.omega_mech_rad_s + copper) / t.bus_v
                               : 0;
        double &oldest = window_[next_++ % window_.size()];
        sum_ += now - oldest;
        oldest = now;
        const double mean = sum_ / static_cast<double>(window_.size());
        if (tick.time_s >= WINDOW_S) {
            largest_a = std::max(largest_a, mean);
            smallest_a = std::min(smallest_a, mean);
        }
        if (tick.time_s >= BRAKED_S + WINDOW_S) {
            braked_a = std::min(braked_a, mean);
        }
        if (tick.time_s >= SETTLED_S && tick.time_s < LOAD_END_S) {
            const double demand = tick.sim->drive().control.current_ref.q;
            settled_a = std::min(settled_a, mean);
            demand_low = std::min(demand_low, demand);
            demand_high = std::max(demand_high, demand);
        }
    }

    double largest_a = 0; // means over a window
    double smallest_a = 0;
    double braked_a = 0;          // the smallest while it is braked
    double settled_a = HUGE_VAL;  // the smallest under load
    double demand_low = HUGE_VAL; // i_q* there, Q15
    double demand_high = -HUGE_VAL;

private:
    double resistance_;
    std::vector<double> window_;
    std::size_t next_ = 0;
    double sum_ = 0;
};

struct Run {
    const char *scenario;
    double rpm;
    double slow_rpm; // braked to
    double load_nm;
    double given_a; // from the supply
    double taken_a; // back into it
};

// Up to speed, under a load beyond the limit, without it, and down.
BusCurrent measure(const Run &one, const char *with, std::vector<std::string> limits)
{
    limits.push_back("scenario.duration_s=3.2");
    limits.push_back(
        fmt::format("scenario.command=[{{time_s=0.1,speed_rpm={}}},{{time_s={},speed_rpm={}}}]",
                    one.rpm, BRAKED_S, one.slow_rpm));
    limits.push_back(
        fmt::format("scenario.load=[{{time_s=1,torque_nm={}}},{{time_s={},torque_nm=0}}]",
                    one.load_nm, LOAD_END_S));
    const nf::Config config = nf::load_scenario(one.scenario, {with}, limits);
    BusCurrent bus(config);
    nf::RunOptions options;
    options.sink = &bus;
    const nf::RunResult result = nf::run_scenario(config, options);
    TEST_ASSERT_EQUAL_size_t_MESSAGE(0, result.faults.size(), one.scenario);
    return bus;
}

struct Allowance {
    double given; // shares of the limit
    double taken;
};

// Two counts of the current converter, one of each phase, of the least current that a limit leaves:
// at full speed. While it accelerates, the low-pass of the voltage is four slow periods behind, in
// which the speed rises by a share of itself: most where the limit begins to act, at ω =
// power/torque with the torque that the ramp takes.
Allowance allowance(const Run &one)
{
    const nf::Config c = nf::load_scenario(one.scenario, {"ideal"}, {});
    const double slow_s = c.tuning.slow_ticks / c.board.pwm_frequency_hz;
    const double rad_s_of_rpm = 3.14159265358979 / 30;
    const double constant = 1.5 * c.motor.pole_pairs * c.motor.flux_linkage_wb; // N·m/A
    const double least_a = std::min(one.given_a, one.taken_a) * c.board.bus_nominal_v /
                           (one.rpm * rad_s_of_rpm) / constant;
    const double lsb_a = c.board.current_full_scale_a / std::ldexp(1.0, c.board.adc_bits - 1);
    const double ramp =
        nf::make_bases(c.motor, c.board).rpm_from_step(nf::build(c).speed_loop.ramp) *
        rad_s_of_rpm / slow_s;
    const double power = one.given_a * c.board.bus_nominal_v;
    const double rounding = 2 * lsb_a / least_a;
    return {rounding + 4 * slow_s * c.motor.inertia_kg_m2 * ramp * ramp / power, rounding};
}

void near(double wanted, double found, double share, const std::string &text)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(share * std::fabs(wanted), wanted, found, text.c_str());
}

TEST(test_the_bus_current_stays_at_its_limits_motoring_and_braking)
{
    const Run runs[] = {{"s1_robust", 1800, 0, 4, 1.2, 0.5},
                        {"s1_odrive_d5065", 5000, 2500, 0.5, 6, 2},
                        {"s1_odrive_d5065", 5000, 0, 0.5, 6, 2}};
    for (const Run &one : runs) {
        for (const char *with : {"ideal", "adc"}) {
            const BusCurrent free = measure(one, with, {});
            const BusCurrent held =
                measure(one, with,
                        {fmt::format("board.bus_current_max_a={}", one.given_a),
                         fmt::format("board.bus_regeneration_max_a={}", one.taken_a)});
            const Allowance allowed = allowance(one);
            const std::string text = fmt::format(
                "{} {}: {:.4g} and {:.4g} A without limits, {:.4g} and {:.4g} A with, {:.4g} A "
                "under load, i_q* {} to {}; allowed {:.3g} and {:.3g}",
                one.scenario, with, free.largest_a, free.smallest_a, held.largest_a,
                held.smallest_a, held.settled_a, held.demand_low, held.demand_high, allowed.given,
                allowed.taken);
            TEST_ASSERT_TRUE_MESSAGE(free.largest_a > 2 * one.given_a, text.c_str());
            TEST_ASSERT_TRUE_MESSAGE(free.smallest_a < -2 * one.taken_a, text.c_str());
            near(one.given_a, held.largest_a, allowed.given, text);
            near(-one.taken_a, held.smallest_a, allowed.taken, text);
            near(one.given_a, held.settled_a, allowed.taken, text);
            /* The limit follows a voltage that it makes: that must not ring. */
            near(held.demand_low, held.demand_high, allowed.taken, text);
        }
    }
}

// 0 is a limit like any other: braked as hard as the load and the losses allow, and two counts of
// the current converter.
TEST(test_a_supply_that_takes_nothing_back_gets_nothing)
{
    for (const char *scenario : {"s1_robust", "s1_odrive_d5065"}) {
        const nf::Config c = nf::load_scenario(scenario, {"ideal"}, {});
        const double rpm = c.motor.rated_speed_rpm;
        const Run one = {scenario, rpm, 0, 0, 0, 0};
        const double lsb_a = c.board.current_full_scale_a / std::ldexp(1.0, c.board.adc_bits - 1);
        const double emf_v = c.motor.pole_pairs * c.motor.flux_linkage_wb * rpm * 3.14159265 / 30;
        const double rounding_a = 2 * lsb_a * 1.5 * emf_v / c.board.bus_nominal_v;
        const BusCurrent free = measure(one, "ideal", {});
        const BusCurrent held = measure(one, "ideal", {"board.bus_regeneration_max_a=0"});
        const std::string text =
            fmt::format("{}: {:.4g} A, without a limit {:.4g} A, allowed {:.4g} A", scenario,
                        held.braked_a, free.braked_a, rounding_a);
        TEST_ASSERT_TRUE_MESSAGE(free.braked_a < -10 * rounding_a, text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(held.braked_a >= -rounding_a, text.c_str());
    }
}

} // namespace
