// SPDX-License-Identifier: MIT
// The heat that the drive counts (i²t) beside that of the plant's own currents: in every state, in
// a short circuit, over resets, and with each motor from cold to hot.
#include "config.h"
#include "numbers.h"
#include "sim.h"

extern "C" {
#include "kept_heat.h"
}

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using Words = std::vector<std::string>;

constexpr double HEAT_OFF = 0.1; // the bound: 10 %
constexpr double WINDING_S = 2;  // a small one, which is warm within the run

// The heat of a winding whose current is known.
class Winding
{
public:
    explicit Winding(const nf::MotorSettings &motor)
        : continuous_a_(motor.continuous_current_a), time_s_(motor.thermal_time_constant_s)
    {
    }
    void pass(const plant_t &plant, double time_s)
    {
        const double square =
            std::pow(plant_motor_i_d(&plant.motor), 2) + std::pow(plant_motor_i_q(&plant.motor), 2);
        heat_ += (square / std::pow(continuous_a_, 2) - heat_) * time_s / time_s_;
    }
    double heat() const
    {
        return heat_;
    }

private:
    double continuous_a_;
    double time_s_;
    double heat_ = 0;
};

// Of the drive's heat less the winding's, in shares of what is allowed.
struct Extent {
    double least = 0;
    double most = 0;
};

// A drive whose background keeps the heat, and its winding. A load holds a speed when it is told
// one.
class Warm
{
public:
    explicit Warm(const nf::Config &config) : config_(config), sim_(config), winding_(config.motor)
    {
        for (const unsigned first :
             {0U, HAL_KEPT_WORDS / 2}) { // of two copies, cold: heat, scale, seal
            hal_keep(&sim_.hal(), first + 1, 1);
            hal_keep(&sim_.hal(), first + 2, ~1U);
        }
        kept_heat_restore(&sim_.app());
    }

    void seconds(double time_s)
    {
        const double period_s = sim_.bases().control_period_s;
        for (long k = std::lround(time_s / period_s); k > 0; k--) {
            turn();
            sim_.control();
            kept_heat_step(&sim_.app());
            judge();
            was_short_ = was_short_ || safe_state_is_short(&drive().safe_state);
            winding_.pass(sim_.plant(), period_s);
            sim_.advance();
        }
    }
    void run_at(double rpm)
    {
        held_rpm_.reset();
        sim_.set_load_nm(0);
        sim_.command_speed_rpm(rpm);
        for (int k = 0; k < 100 && !is_at(rpm); k++) {
            sim_.request(drive().state == DRIVE_STATE_FAULT ? DRIVE_REQUEST_CLEAR
                                                            : DRIVE_REQUEST_RUN);
            seconds(0.05);
        }
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive().state);
        TEST_ASSERT_TRUE(is_at(rpm));
    }
    void load(double share)
    {
        sim_.set_load_nm(share * 1.5 * config_.motor.pole_pairs * config_.motor.flux_linkage_wb *
                         config_.motor.continuous_current_a);
    }
    void stop()
    {
        sim_.request(0);
    }
    void discharge_bus()
    {
        sim_.seam().plant.bus_v = config_.board.bus_nominal_v;
    }
    void hold(double rpm)
    {
        held_rpm_ = rpm;
    }
    // The supply stays, the rotor turns on.
    void reset()
    {
        const int32_t before = drive().derating.heat_q24;
        TEST_ASSERT_NULL(app_init(&sim_.app(), &sim_.hal(), &sim_.cfg()));
        kept_heat_restore(&sim_.app());
        TEST_ASSERT_EQUAL_INT32(before, drive().derating.heat_q24);
    }
    const drive_t &drive() const
    {
        return sim_.drive();
    }
    double heat() const
    {
        return std::ldexp(drive().derating.heat_q24, -24);
    }
    double winding() const
    {
        return winding_.heat();
    }
    bool was_short() const
    {
        return was_short_;
    }
    const std::map<drive_state_t, Extent> &seen() const
    {
        return seen_;
    }

private:
    bool is_at(double rpm) const
    {
        const double found = sim_.plant().motor.now.omega_el_rad_s / config_.motor.pole_pairs;
        return drive().state == DRIVE_STATE_RUN &&
               std::abs(found / nf::rad_s_from_rpm(rpm) - 1) < 0.05;
    }
    // So stiff that an excess decays in 3 ms.
    void turn()
    {
        if (held_rpm_) {
            const double excess = sim_.plant().motor.now.omega_el_rad_s / config_.motor.pole_pairs -
                                  nf::rad_s_from_rpm(*held_rpm_);
            sim_.set_load_nm(config_.motor.inertia_kg_m2 / 3e-3 * excess);
        }
    }
    // What a current makes between two looks of the drive at it.
    double look_at(double current_a) const
    {
        const double look_s =
            sim_.bases().control_period_s * sim_.cfg().slow_ticks * SUPERVISION_STEPS;
        return std::pow(current_a / config_.motor.continuous_current_a, 2) * look_s /
               config_.motor.thermal_time_constant_s;
    }
    // In a short circuit one look may be at a current that the converter cannot measure: it counts
    // as the largest in both axes.
    void judge()
    {
        const double off = heat() - winding_.heat();
        const double allowed = HEAT_OFF * winding_.heat();
        const double less = allowed + look_at(config_.motor.max_current_a);
        const double more = allowed + look_at(std::sqrt(2.0) * sim_.bases().current_a);
        Extent &extent = seen_[drive().state];
        extent.least = std::min(extent.least, off / less);
        extent.most = std::max(extent.most, off / more);
    }

    nf::Config config_;
    nf::Simulation sim_;
    Winding winding_;
    std::optional<double> held_rpm_;
    bool was_short_ = false;
    std::map<drive_state_t, Extent> seen_;
};

struct Machine {
    const char *motor;
    const char *board;
    const char *tuning;
    Words set;
    double rpm;
    double held_rpm; // the EMF is above the bus's limit, where the board shorts the motor
    bool shorts;
    bool sees_all; // the current of the short circuit is within what the converter measures
};
const char *const SOURCE = "plant.bus_source_resistance_ohm=1"; // takes nothing back
const Machine MACHINES[] = {
    {"compressor",
     "compressor_310v",
     "any",
     {"plant.bus_capacitance_f=680e-6", SOURCE},
     4000,
     8000,
     true,
     true},
    {"motor_a_weakened",
     "bench_310v_short",
     "robust_motor_a",
     {"plant.bus_capacitance_f=1e-3", SOURCE},
     1200,
     3000,
     true,
     false},
    {"motor_a", "bench_310v", "any", {}, 1200, 1200, false, true},
};

nf::Config configured(const Machine &machine)
{
    Words set = machine.set;
    set.push_back(fmt::format("motor.thermal_time_constant_s={}", WINDING_S));
    return nf::load_parts(machine.motor, machine.board, machine.tuning, {}, set);
}

void pass_every_state(Warm &warm, const Machine &machine)
{
    warm.run_at(machine.rpm);
    warm.load(0.8);
    warm.seconds(1);
    warm.reset();
    warm.load(0);
    warm.seconds(0.2);
    warm.run_at(machine.rpm);
    warm.hold(machine.held_rpm);
    warm.stop();
    warm.seconds(1.5);
    warm.reset();
    warm.seconds(0.5);
    warm.hold(0);
    warm.seconds(0.5);
    warm.discharge_bus();
    warm.seconds(3 * WINDING_S); // a current beyond what is measured has counted as the largest
    warm.run_at(machine.rpm / 2);
    warm.load(1);
    warm.seconds(1);
}

} // namespace

TEST(test_the_heat_is_that_of_the_winding_in_each_state_and_over_resets)
{
    for (const Machine &machine : MACHINES) {
        Warm warm(configured(machine));
        pass_every_state(warm, machine);
        TEST_ASSERT_EQUAL_INT(machine.shorts, warm.was_short());
        for (const drive_state_t state :
             {DRIVE_STATE_OFFSET_CAL, DRIVE_STATE_READY, DRIVE_STATE_FLYING_START,
              DRIVE_STATE_ALIGN, DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN}) {
            TEST_ASSERT_EQUAL_UINT(1, warm.seen().count(state));
        }
        for (const auto &[state, extent] : warm.seen()) {
            fmt::print("{}: state {}: {:.2f} to {:.2f} of what is allowed\n", machine.motor,
                       static_cast<int>(state), extent.least, extent.most);
            TEST_ASSERT_TRUE(extent.least > -1);
            TEST_ASSERT_TRUE(extent.most < 1 || !machine.sees_all);
        }
        fmt::print("{}: heat {:.3f}, of the winding {:.3f}\n", machine.motor, warm.heat(),
                   warm.winding());
    }
}
