// SPDX-License-Identifier: MIT
// The safe state in whole runs: what the bus and the windings bear when the gates open or the motor is shorted, from any point of
// operation; each fault at speeds at which open gates would overcharge the bus.
#include "config.h"
#include "injection.h"
#include "machine.h"
#include "numbers.h"
#include "safe_state_units.h"
#include "sim.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unity.h>

namespace
{

using Words = std::vector<std::string>;

constexpr double ROOT_3 = 1.7320508075688772;

// A salient motor with little flux and much inductance. This drive does not weaken the field: its highest speed is where the
// EMF meets the voltage circle. An over-hauling load makes the speeds above.
struct Machine {
    const char *motor;
    const char *board;
    const char *tuning;
    Words set;
};
const Machine COMPRESSOR = {
    "motor_a",
    "compressor_310v",
    "robust",
    {"motor.pole_pairs=3", "motor.resistance_ohm=0.6", "motor.inductance_d_h=8e-3",
     "motor.inductance_q_h=12e-3", "motor.flux_linkage_wb=0.1", "motor.rated_torque_nm=2.5",
     "motor.rated_speed_rpm=4500", "motor.max_speed_rpm=5200", "motor.max_current_a=8",
     "motor.inertia_kg_m2=1e-3", "motor.viscous_friction_nm_s=1e-4",
     "plant.bus_capacitance_f=680e-6", "plant.bus_source_resistance_ohm=1"}};
constexpr double HIGHEST_RPM = 8000; // of the load, and of a drive that weakens the field

nf::Config configured(const Machine &machine, const Words &more = {})
{
    Words set = machine.set;
    set.insert(set.end(), more.begin(), more.end());
    return nf::load_parts(machine.motor, machine.board, machine.tuning, {}, set);
}

double rpm_of(const nf::Config &config, double speed_el)
{
    return speed_el / config.motor.pole_pairs / nf::rad_s_from_rpm(1);
}

// ---- the plant alone: the formulas

constexpr double STILL_INERTIA = 1e3; // the speed stays

// A machine that turns, with this current in its windings and this voltage on its bus.
plant_t machine_at(const nf::Config &config, double speed_el, double i_d, double i_q, double bus_v)
{
    const drive_cfg_t cfg =
        nf::make_drive_cfg(config.motor, config.board, config.tuning, config.model);
    plant_cfg_t plant_cfg = nf::make_plant_cfg(config, cfg);
    plant_cfg.motor.inertia_kg_m2 = STILL_INERTIA;
    plant_cfg.motor.initial_speed_mech_rad_s = speed_el / config.motor.pole_pairs;
    plant_cfg.supply.voltage_v = bus_v;
    plant_cfg.trip_a = 0;
    plant_t plant;
    const char *bad = nullptr;
    TEST_ASSERT_TRUE_MESSAGE(plant_init(&plant, &plant_cfg, &bad), bad);
    plant.motor.now.flux_d_wb = config.motor.flux_linkage_wb + config.motor.inductance_d_h * i_d;
    plant.motor.now.flux_q_wb = config.motor.inductance_q_h * i_q;
    return plant;
}

double amplitude_a(const plant_t &plant)
{
    return std::hypot(plant_motor_i_d(&plant.motor), plant_motor_i_q(&plant.motor));
}

struct Peak {
    double bus_v = 0;
    double current_a = 0;
};

Peak peak_of(plant_t plant, bool shorted, double time_s)
{
    Peak peak;
    plant_set_gates(&plant, shorted); // all compare values are 0
    const long periods = std::lround(time_s / plant.inverter.period_s);
    for (long k = 0; k < periods; k++) {
        plant_step(&plant);
        peak.bus_v = std::max(peak.bus_v, plant.bus_v);
        peak.current_a = std::max(peak.current_a, amplitude_a(plant));
    }
    return peak;
}

constexpr int POINTS = 400;
constexpr double OPEN_TIME_S = 0.2;  // 40 electrical turns: the bus has settled
constexpr double SHORT_TIME_S = 0.1; // 5 of L/R
// The bound is for the worst angle of all, at which the EMF of two phases stands still. It does not, so some room is left,
// but not so much that the formula would be of no use.
constexpr double BUS_SHARE_LEAST = 0.75;

// Whatever current flows, and whatever the bus between its lowest and its nominal voltage.
void test_up_to_the_safe_speed_open_gates_leave_the_bus_within_its_limit()
{
    for (const char *capacitance : {"150e-6", "680e-6", "2e-3"}) {
        const nf::Config config =
            configured(COMPRESSOR, {fmt::format("plant.bus_capacitance_f={}", capacitance),
                                    fmt::format("board.bus_capacitance_f={}", capacitance)});
        const double safe = nf::safe_open_speed(config.motor, config.board);
        std::mt19937 random(1);
        double highest_v = 0;
        for (int k = 0; k < POINTS; k++) {
            const auto uniform = [&](double lo, double hi) {
                return std::uniform_real_distribution<double>(lo, hi)(random);
            };
            const double angle = uniform(-nf::PI, nf::PI);
            const double amplitude = config.board.overcurrent_a * std::sqrt(uniform(0, 1));
            const double bus_v = k % 2 == 0
                                     ? config.board.bus_min_v
                                     : uniform(config.board.bus_min_v, config.board.bus_nominal_v);
            const plant_t plant = machine_at(config, safe, amplitude * std::cos(angle),
                                             amplitude * std::sin(angle), bus_v);
            highest_v = std::max(highest_v, peak_of(plant, false, OPEN_TIME_S).bus_v);
        }
        fmt::print("{} F: safe up to {:.0f} rpm, EMF {:.1f} V, highest bus {:.1f} V of {:g} V\n",
                   capacitance, rpm_of(config, safe),
                   ROOT_3 * safe * config.motor.flux_linkage_wb, highest_v, config.board.bus_max_v);
        TEST_ASSERT_TRUE(highest_v <= config.board.bus_max_v);
        TEST_ASSERT_TRUE(highest_v >= BUS_SHARE_LEAST * config.board.bus_max_v);
    }
}

// The peak is computed for the largest flux that a point of operation has, at the lowest speed, and the slowest decay, at the highest
// one.
constexpr double PEAK_SHARE_LEAST = 0.75;

void test_the_peak_of_the_short_circuit_current_is_within_the_computed_one()
{
    const nf::Config config = configured(COMPRESSOR);
    const double safe = nf::safe_open_speed(config.motor, config.board);
    const double fastest = nf::rad_s_from_rpm(HIGHEST_RPM) * config.motor.pole_pairs;
    const double bound = nf::short_circuit_peak(config.motor, config.board, fastest);
    std::mt19937 random(1);
    double highest_a = 0;
    for (int k = 0; k < POINTS; k++) {
        const auto uniform = [&](double lo, double hi) {
            return std::uniform_real_distribution<double>(lo, hi)(random);
        };
        // A point of operation: no current along the magnets, and the flux that the voltage can turn.
        const double angle = uniform(nf::PI / 2, 3 * nf::PI / 2);
        const double amplitude = config.motor.max_current_a * std::sqrt(uniform(0, 1));
        const double speed = uniform(safe, fastest);
        const plant_t plant = machine_at(config, speed, amplitude * std::cos(angle),
                                         amplitude * std::sin(angle), config.board.bus_nominal_v);
        const double flux = std::hypot(plant.motor.now.flux_d_wb, plant.motor.now.flux_q_wb);
        if (speed * flux <= nf::largest_ratio(config.board) * config.board.bus_max_v) {
            highest_a = std::max(highest_a, peak_of(plant, true, SHORT_TIME_S).current_a);
        }
    }
    fmt::print("short circuit: highest {:.1f} A, computed {:.1f} A, in the end {:.2f} A\n",
               highest_a, bound, nf::short_circuit_current(config.motor, fastest));
    TEST_ASSERT_TRUE(highest_a <= bound);
    TEST_ASSERT_TRUE(highest_a >= PEAK_SHARE_LEAST * bound);
}

constexpr double STEADY_TOLERANCE = 0.002; // the plant's integration, and what has not decayed after 0.5 s

void test_the_short_circuit_current_in_the_end_is_the_computed_one()
{
    const nf::Config config = configured(COMPRESSOR);
    for (const double rpm : {200.0, 1000.0, 4000.0, HIGHEST_RPM}) {
        const double speed = nf::rad_s_from_rpm(rpm) * config.motor.pole_pairs;
        plant_t plant = machine_at(config, speed, 0, 0, config.board.bus_nominal_v);
        (void)peak_of(plant, true, 0);
        plant_set_gates(&plant, true);
        for (int k = 0; k < 5000; k++) {
            plant_step(&plant);
        }
        const double computed = nf::short_circuit_current(config.motor, speed);
        TEST_ASSERT_DOUBLE_WITHIN(STEADY_TOLERANCE * computed, computed, amplitude_a(plant));
    }
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
    RUN_TEST(test_up_to_the_safe_speed_open_gates_leave_the_bus_within_its_limit);
    RUN_TEST(test_the_peak_of_the_short_circuit_current_is_within_the_computed_one);
    RUN_TEST(test_the_short_circuit_current_in_the_end_is_the_computed_one);
    return UNITY_END();
}
