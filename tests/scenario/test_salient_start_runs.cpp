// SPDX-License-Identifier: MIT
// Starts of motors with so much saliency that φ/(L_q − L_d), the current at which the rotor has no
// stiffness on an imposed vector, is near the continuous current: each is held, ends in a fault, or
// is refused. None is lost without a word.
#include "origin.h"
#include "per_unit.h"
#include "scenario.h"
#include "si.h"
#include "startup_units.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using Words = std::vector<std::string>;

class Random
{
public:
    explicit Random(unsigned seed) : generator_(seed)
    {
    }
    double uniform(double low, double high)
    {
        return low + (high - low) * static_cast<double>(generator_()) / 4294967296.0;
    }
    double log_uniform(double low, double high)
    {
        return low * std::pow(high / low, uniform(0, 1));
    }

private:
    std::mt19937 generator_;
};

// Buses with the power that is usual on them, their PWM and what their switches take.
struct Supply {
    double bus_v;
    double least_w;
    double most_w;
    double least_hz;
    double most_hz;
    double dead_time_s;
    double drop_v;
};
constexpr Supply SUPPLIES[] = {
    {24, 50, 600, 16000, 40000, 0.4e-6, 0},     {48, 100, 3000, 16000, 32000, 0.5e-6, 0},
    {96, 1000, 12000, 10000, 24000, 0.6e-6, 0}, {310, 200, 10000, 8000, 20000, 1.2e-6, 1},
    {350, 8000, 1e5, 8000, 12000, 2e-6, 1.2},   {560, 1000, 5e4, 6000, 16000, 2e-6, 1.2},
    {800, 2e4, 1e5, 8000, 16000, 1.5e-6, 1},
};

// The electrical speed turns by at most so much in a period of the PWM.
constexpr double TURN_MAX_RAD = 0.25;
// At rated speed and current with i_d = 0 the voltage is this share of what the bus gives.
constexpr double VOLTAGE_SHARE = 0.85;

constexpr double CURRENT_MAX_A = 360;        // 2000 A of full scale is the largest converter
constexpr double RESISTANCE_MIN_OHM = 0.001; // with the wires

struct Salient {
    Words set;
    std::string what;
    double start_rpm = 0;
};

void add(Words &set, const char *key, double value)
{
    set.push_back(fmt::format("{}={}", key, value));
}

void add_board(Words &set, Random &random, const Supply &supply, double pwm_hz,
               double max_current_a)
{
    const double full_scale_a = max_current_a * random.uniform(1.3, 2.5);
    add(set, "board.pwm_frequency_hz", std::round(pwm_hz));
    add(set, "board.current_full_scale_a", full_scale_a);
    add(set, "board.overcurrent_a",
        std::min(0.9 * full_scale_a, max_current_a * random.uniform(1.2, 1.5)));
    add(set, "board.trip_a", 0);
    add(set, "board.offset_max_a", 0.03 * full_scale_a);
    add(set, "board.bus_nominal_v", supply.bus_v);
    add(set, "board.bus_full_scale_v", 1.5 * supply.bus_v);
    add(set, "board.bus_min_v", 0.6 * supply.bus_v);
    add(set, "board.bus_max_v", 1.25 * supply.bus_v);
    add(set, "board.dead_time_s", supply.dead_time_s);
    add(set, "board.device_drop_v", supply.drop_v);
    add(set, "board.duty_margin_pct", 5);
    set.push_back("board.output_capacitance_f=-1");
}

// L_q/L_d 1.5 to 4, φ/(L_q − L_d) 0.5 to 3 of the continuous current, 50 W to 100 kW.
Salient draw(Random &random)
{
    const Supply &supply = SUPPLIES[static_cast<std::size_t>(random.uniform(0, 7))];
    const double asked_w = random.log_uniform(supply.least_w, supply.most_w);
    const double pwm_hz = random.log_uniform(supply.least_hz, supply.most_hz);
    const int pole_pairs = static_cast<int>(random.uniform(2, 9));
    const double fastest_rpm = TURN_MAX_RAD * pwm_hz / pole_pairs / nf::RAD_S_PER_RPM;
    const double rated_rpm = std::min(random.log_uniform(1000, 6000), fastest_rpm / 1.2);
    const double rated_el = rated_rpm * nf::RAD_S_PER_RPM * pole_pairs;
    const double saliency = random.uniform(1.5, 4);
    const double stiff = random.log_uniform(0.5, 3); // φ/(L_q − L_d) over the continuous current
    const double reactance_q = saliency / ((saliency - 1) * stiff);
    const double emf_v =
        VOLTAGE_SHARE * supply.bus_v / std::sqrt(3.0) / std::hypot(1.05, reactance_q);
    const double current_a = std::min(asked_w / (1.5 * emf_v), CURRENT_MAX_A);
    const double power_w = 1.5 * emf_v * current_a;
    const double flux_wb = emf_v / rated_el;
    const double difference_h = flux_wb / (stiff * current_a);
    const double torque_nm = 1.5 * pole_pairs * flux_wb * current_a;
    const double speed = rated_rpm * nf::RAD_S_PER_RPM;
    const double inertia = torque_nm * random.log_uniform(0.02, 5) / speed;
    const double max_current_a = current_a * random.uniform(1.2, 2.2);
    Salient one;
    add(one.set, "motor.pole_pairs", pole_pairs);
    add(one.set, "motor.resistance_ohm",
        std::max(RESISTANCE_MIN_OHM, random.log_uniform(0.01, 0.12) *
                                         std::pow(power_w / 1000, -0.2) * emf_v / current_a));
    add(one.set, "motor.inductance_d_h", difference_h / (saliency - 1));
    add(one.set, "motor.inductance_q_h", saliency * difference_h / (saliency - 1));
    add(one.set, "motor.flux_linkage_wb", flux_wb);
    add(one.set, "motor.rated_torque_nm", torque_nm);
    add(one.set, "motor.rated_speed_rpm", rated_rpm);
    add(one.set, "motor.max_speed_rpm", 1.1 * rated_rpm);
    add(one.set, "motor.max_current_a", max_current_a);
    add(one.set, "motor.continuous_current_a", current_a);
    add(one.set, "motor.inertia_kg_m2", inertia);
    add(one.set, "motor.viscous_friction_nm_s", random.uniform(0.002, 0.03) * torque_nm / speed);
    add_board(one.set, random, supply, pwm_hz, max_current_a);
    one.start_rpm = random.uniform(0.25, 0.6) * rated_rpm;
    one.what = fmt::format("{:.3g} W, {} V, L_q/L_d {:.2f}, φ/(L_q − L_d) {:.2f} of the current",
                           power_w, supply.bus_v, saliency, stiff);
    return one;
}

enum class Outcome {
    held,
    fault,
    refused,
    lost
};

// From standstill at any angle to a share of rated speed, with the time that its ramp takes three
// times over.
nf::Config start_of(Salient motor, Random &random)
{
    motor.set.push_back(
        fmt::format("scenario.command=[{{time_s=0.1, speed_rpm={}}}]", motor.start_rpm));
    motor.set.emplace_back("scenario.load=[]");
    add(motor.set, "scenario.initial_angle_el_deg", random.uniform(-180, 180));
    const nf::Config first = nf::load_scenario("any", {"adc"}, motor.set);
    const nf::TuningSettings tuning =
        nf::settled_tuning(first.motor, first.board, first.tuning, first.model);
    add(motor.set, "scenario.duration_s", 1.6 + 3 * motor.start_rpm / tuning.speed_ramp_rpm_s);
    return nf::load_scenario("any", {"adc"}, motor.set);
}

// A start that fails is repeated; only the last one is a fault.
nf::RunResult run_to_the_end(nf::Config config)
{
    nf::RunResult result = nf::run_scenario(config);
    if (result.faults.empty() && !result.metrics.locked) {
        const drive_cfg_t cfg =
            nf::make_drive_cfg(config.motor, config.board, config.tuning, config.model);
        config.scenario.duration_s +=
            cfg.startup.attempts * nf::startup_time(config.motor, config.board, config.tuning);
        result = nf::run_scenario(config);
    }
    return result;
}

Outcome outcome_of(const nf::RunResult &result)
{
    if (!result.faults.empty()) {
        return Outcome::fault;
    }
    return result.metrics.locked ? Outcome::held : Outcome::lost;
}

Outcome try_start(unsigned seed)
{
    Random random(seed);
    const Salient motor = draw(random);
    try {
        const nf::RunResult result = run_to_the_end(start_of(motor, random));
        const Outcome outcome = outcome_of(result);
        if (outcome != Outcome::held) {
            fmt::print("seed {}, {}: {}\n", seed, motor.what,
                       outcome == Outcome::fault ? fault_text(result.faults.front().id)->name
                                                 : "lost");
        }
        return outcome;
    } catch (const std::runtime_error &error) {
        fmt::print("seed {}, {}: {}\n", seed, motor.what, error.what());
        return Outcome::refused;
    }
}

// What the generator draws is a motor that somebody may have: of a hundred five may end in a fault
// or a refusal.
constexpr double HELD_SHARE = 0.95;

TEST(test_each_salient_motor_starts_or_ends_in_words)
{
    const unsigned count = testing_runs(8, 200);
    std::map<Outcome, unsigned> outcomes;
    for (unsigned seed = 1; seed <= count; seed++) {
        outcomes[try_start(seed)]++;
    }
    fmt::print("{} held, {} faults, {} refused, {} lost\n", outcomes[Outcome::held],
               outcomes[Outcome::fault], outcomes[Outcome::refused], outcomes[Outcome::lost]);
    TEST_ASSERT_EQUAL_UINT(0, outcomes[Outcome::lost]);
    TEST_ASSERT_TRUE(outcomes[Outcome::held] >= HELD_SHARE * count);
}

// A traction motor whose φ/(L_q − L_d) of 267 A is just above its continuous current: before, 333 A
// turned its rotor off the vector.
TEST(test_a_traction_motor_is_started_with_half_of_the_current_that_has_no_stiffness)
{
    Salient traction;
    traction.set = {"motor.pole_pairs=4",          "motor.resistance_ohm=0.009",
                    "motor.inductance_d_h=170e-6", "motor.inductance_q_h=440e-6",
                    "motor.flux_linkage_wb=0.072", "motor.rated_torque_nm=110",
                    "motor.rated_speed_rpm=3200",  "motor.max_speed_rpm=5000",
                    "motor.max_current_a=450",     "motor.continuous_current_a=240",
                    "motor.inertia_kg_m2=0.4",     "motor.viscous_friction_nm_s=0.01"};
    Random random(1);
    add_board(traction.set, random, SUPPLIES[4], 10000, 450);
    traction.start_rpm = 1500;
    const nf::Config config = start_of(traction, random);
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    const drive_cfg_t cfg =
        nf::make_drive_cfg(config.motor, config.board, config.tuning, config.model);
    const double imposed_a = cfg.startup.align.current_high / 32768.0 * bases.current_a;
    TEST_ASSERT_DOUBLE_WITHIN(bases.current_a / 32768, 0.5 * 0.072 / 270e-6, imposed_a);
    TEST_ASSERT_EQUAL(Outcome::held, outcome_of(nf::run_scenario(config)));
}

} // namespace
