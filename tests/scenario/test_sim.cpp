// SPDX-License-Identifier: MIT
// The coupling of plant, hardware binding and drive, and what a run does with its profiles.
#include "fault_line.h"
#include "machine.h"
#include "profile.h"
#include "report.h"
#include "scenario.h"
#include "signals.h"
#include "tick.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using nf::Config;

Config load(const std::vector<std::string> &set = {})
{
    return nf::load_scenario("s1", {}, set);
}

// Gates and compare values as the plant sees them after the control interrupt.
TEST(test_compare_values_are_preloaded_and_gates_are_not)
{
    const nf::Simulation sim(load());
    drive_out_t out{};
    out.compare = {{10, 20, 30}};
    out.gate_enable = true;
    plant_t plant = sim.plant();
    hal_t hal{};
    hal_host_init(&hal, &plant);
    hal_apply(&hal, &out);
    TEST_ASSERT_TRUE(plant.gates_on);
    TEST_ASSERT_EQUAL_UINT32(0, plant.compare[1]);
    hal_host_step(&hal);
    TEST_ASSERT_EQUAL_UINT32(20, plant.compare[1]);
    TEST_ASSERT_EQUAL_UINT32(1, hal_ticks(&hal));
    hal_open_gates(&hal);
    TEST_ASSERT_FALSE(plant.gates_on);
}

TEST(test_drive_reaches_run_on_request_only)
{
    const Config config = load();
    nf::Simulation sim(config);
    const auto run = [&sim](int ticks) {
        for (int k = 0; k < ticks; k++) {
            sim.control();
            sim.advance();
        }
    };
    run(400);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, sim.drive().state);
    TEST_ASSERT_FALSE(sim.plant().gates_on);
    while (!drive_reads_slow_inputs(&sim.drive())) {
        run(1);
    }
    sim.request(DRIVE_REQUEST_RUN);
    run(1);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, sim.drive().state);
    TEST_ASSERT_FALSE(sim.plant().gates_on);
    run(1);
    TEST_ASSERT_TRUE(sim.plant().gates_on);
}

TEST(test_plant_scales_apply_to_the_plant_alone)
{
    const Config config = load({"plant.resistance_scale=1.5", "plant.flux_scale=0.9"});
    const drive_cfg_t drive = nf::build(config);
    const drive_cfg_t unscaled = nf::build(load());
    const plant_cfg_t plant = nf::make_plant_cfg(config, drive);
    TEST_ASSERT_EQUAL_DOUBLE(1.5 * config.motor.resistance_ohm, plant.motor.resistance_ohm);
    TEST_ASSERT_EQUAL_DOUBLE(0.9 * config.motor.flux_linkage_wb, plant.motor.flux_linkage_wb);
    TEST_ASSERT_EQUAL_INT32(unscaled.observer.decay, drive.observer.decay);
    TEST_ASSERT_EQUAL_INT32(drive.modulator.timer_counts, plant.inverter.timer_counts);
}

// Free, both masses swing at the resonance; with the rotor held the load swings at the
// antiresonance, half of it with 1 : 3.
TEST(test_an_elastic_shaft_has_the_resonance_and_the_inertias_of_its_keys)
{
    const Config config = load({"plant.shaft_resonance_hz=80", "plant.load_inertia_ratio=3",
                                "plant.shaft_damping_pct=4", "plant.inertia_scale=2"});
    const plant_motor_cfg_t motor = nf::make_plant_cfg(config, nf::build(config)).motor;
    const double all = 2 * config.motor.inertia_kg_m2;
    const double w = 2 * 3.14159265358979323846 * 80;
    const double both = 1 / motor.inertia_kg_m2 + 1 / motor.load_inertia_kg_m2;
    TEST_ASSERT_EQUAL_DOUBLE(all / 4, motor.inertia_kg_m2);
    TEST_ASSERT_EQUAL_DOUBLE(all * 3 / 4, motor.load_inertia_kg_m2);
    TEST_ASSERT_EQUAL_DOUBLE(w, std::sqrt(motor.shaft_stiffness_nm * both));
    TEST_ASSERT_EQUAL_DOUBLE(w / 2, std::sqrt(motor.shaft_stiffness_nm / motor.load_inertia_kg_m2));
    TEST_ASSERT_EQUAL_DOUBLE(0.04, motor.shaft_damping_nm_s * both / (2 * w));
}

TEST(test_without_a_resonance_the_shaft_is_rigid)
{
    const Config config = load({"plant.load_inertia_ratio=3"});
    const plant_motor_cfg_t motor = nf::make_plant_cfg(config, nf::build(config)).motor;
    TEST_ASSERT_EQUAL_DOUBLE(config.motor.inertia_kg_m2, motor.inertia_kg_m2);
    TEST_ASSERT_TRUE(motor.load_inertia_kg_m2 == 0);
}

// "" when it is simulated.
std::string refusal_of(const std::vector<std::string> &set)
{
    try {
        const nf::Simulation sim(load(set));
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

// Half of 155 V for six times 2 µs on 11.6 mH, 1000 steps of 0.5: 1.6·10⁻⁴ A, of which the next 5 %
// are not offered.
TEST(test_a_knee_that_cannot_be_followed_is_refused_with_what_can)
{
    const std::string refusal =
        refusal_of({"plant.dead_time_s=2e-6", "plant.commutation_knee_a=1e-5"});
    const std::string expected =
        "--set: plant.commutation_knee_a = 1e-05: is too small to be followed with this dead time, "
        "drop and inductance; allowed: 0, or at least 0.00017 A";
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), refusal.c_str());
    TEST_ASSERT_EQUAL_STRING(
        "", refusal_of({"plant.dead_time_s=2e-6", "plant.commutation_knee_a=0.00017"}).c_str());
}

// g_d = 0.3/(0.49·3.7), g_q = 0.5/0.125; 0.9/√(g_d·g_q·L_d/L_q) with a q axis of half the
// inductance.
TEST(test_cross_saturation_that_has_no_inverse_is_refused_with_what_has)
{
    std::vector<std::string> set = {"plant.saliency_scale=0.5", "plant.saturation_d_pct=30",
                                    "plant.saturation_q_pct=50", "plant.saturation_cross_pct=79"};
    const std::string expected =
        "--set: plant.saturation_cross_pct = 79: makes L_q infinite for some i_d < 0, "
        "with plant.saturation_d_pct, saturation_q_pct and this L_d/L_q; allowed: 0 to 78 %";
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), refusal_of(set).c_str());
    set.back() = "plant.saturation_cross_pct=78";
    TEST_ASSERT_EQUAL_STRING("", refusal_of(set).c_str());
}

TEST(test_profile_acts_at_the_nearest_tick)
{
    nf::Profile profile({{-0.01, 5}, {0.0, 5}, {0.0101, 7}}, 1e-3, 20);
    std::vector<int64_t> changes;
    for (int64_t tick = 0; tick < 100; tick++) {
        if (profile.advance(tick)) {
            changes.push_back(tick);
        }
    }
    TEST_ASSERT_EQUAL_size_t(2, changes.size()); // repeating a value is no step
    TEST_ASSERT_EQUAL_INT64(10, changes[0]);
    TEST_ASSERT_EQUAL_INT64(30, changes[1]);
    TEST_ASSERT_EQUAL_DOUBLE(7, profile.value());
}

// A rotor at 90° electrical against an estimate of 100°, and across the ends of the turn.
TEST(test_angle_error_wraps)
{
    constexpr double DEG = 3.14159265358979323846 / 180.0;
    constexpr int64_t TURN = int64_t{1} << 32;
    nf::Tick tick{};
    tick.truth.theta_el_rad = 90 * DEG;
    tick.position_estimate_q32 = 5 * TURN + TURN * 100 / 360;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -10.0, nf::angle_error_deg(tick));
    tick.truth.theta_el_rad = -179 * DEG;
    tick.position_estimate_q32 = -3 * TURN + TURN * 179 / 360;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, nf::angle_error_deg(tick));
}

// What the plant is loaded with, not what the file says.
class LargestLoad : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        largest_nm = std::max(largest_nm, tick.load_nm);
    }
    double largest_nm = 0;
};

TEST(test_load_scale_applies_to_every_torque_of_the_load)
{
    Config config = load({"scenario.load_scale=0.5", "scenario.duration_s=0.05"});
    config.scenario.load = {{0.01, 2.0}, {0.02, 3.0}};
    LargestLoad load_seen;
    nf::RunOptions options;
    options.sink = &load_seen;
    (void)nf::run_scenario(config, options);
    TEST_ASSERT_EQUAL_DOUBLE(1.5, load_seen.largest_nm);
}

// The first evaluated tick of a scenario that does not say how long its prelude is.
TEST(test_the_drive_runs_from_t_0_on)
{
    const Config config = load({"scenario.prelude_s=0"});
    TEST_ASSERT_TRUE(nf::run_scenario(config).metrics.locked);
}

// By the board's line of its sensor: 0 to 4096 counts are -50 to 150 °C here.
TEST(test_a_fault_of_temperature_is_said_in_degrees)
{
    const Config config =
        load({"board.temperature_points_c=[-50, 150]", "board.temperature_points_pct=[0, 100]"});
    const nf::FoundFault fault = {{FAULT_OVERTEMPERATURE, 3174, 3072, 0}, {}};
    TEST_ASSERT_EQUAL_STRING(
        "OVERTEMPERATURE: 105.0 °C, limit 100.0 °C",
        nf::fault_measure(fault, nf::make_bases(config.motor, config.board), &config.board)
            .c_str());
}

// What stays in the state when driving ends is not shown as if it were so.
TEST(test_with_open_gates_no_signal_tells_what_the_drive_does_not_know)
{
    const Config config = load();
    nf::Simulation sim(config);
    for (const drive_state_t state : {DRIVE_STATE_READY, DRIVE_STATE_RUN}) {
        sim.seam().drive.state = state;
        const nf::Tick tick = nf::tick_of_frame(sim, sim.in(), 0);
        for (const char *name :
             {"speed_estimated_rpm", "position_estimated_rad", "angle_estimated_el_deg",
              "i_q_measured_a", "i_d_measured_a", "i_q_estimated_a", "i_q_reference_a", "v_q_v"}) {
            const nf::SignalInfo &signal = *nf::find_signal(name);
            TEST_ASSERT_EQUAL_MESSAGE(state == DRIVE_STATE_READY,
                                      std::isnan(nf::si_value(signal, tick)), name);
            TEST_ASSERT_TRUE_MESSAGE(nf::is_told(signal, tick), name);
        }
    }
}

// 10 half-waves in 25 slow periods of 1 ms; of another fault a swing before it is not said.
TEST(test_a_fault_of_a_swing_is_said_with_amplitude_and_frequency)
{
    const Config config = load();
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    const drive_cfg_t cfg = nf::build(config);
    drive_t drive{};
    drive.cfg = &cfg;
    drive.watch.oscillation.span = 25;
    drive.fault = {FAULT_OSCILLATION, 8192, 2048, 0};
    TEST_ASSERT_EQUAL_STRING("OSCILLATION: 10 A at 200.0 Hz, limit 2.5 A",
                             nf::fault_measure(nf::found_fault(drive, bases), bases).c_str());
    drive.fault.id = FAULT_OVERCURRENT;
    TEST_ASSERT_EQUAL_STRING("OVERCURRENT: 10 A, limit 2.5 A",
                             nf::fault_measure(nf::found_fault(drive, bases), bases).c_str());
    drive.watch.oscillation.span = 0;
    TEST_ASSERT_FALSE(nf::last_swing_hz(drive, bases).has_value());
}

// Opening the measuring range's protection: the fault is named with its tick, and lock is lost.
TEST(test_faults_are_listed)
{
    const Config config = load({"plant.bus_ripple_pct=40"});
    const nf::RunResult result = nf::run_scenario(config);
    TEST_ASSERT_EQUAL_size_t(1, result.faults.size());
    const fault_t &fault = result.faults.front();
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, fault.id);
    TEST_ASSERT_EQUAL_STRING(fmt::format("OVERVOLTAGE@{} (-0.0123 s)", fault.tick).c_str(),
                             nf::fault_mark(fault, -0.0123).c_str());
    TEST_ASSERT_FALSE(result.metrics.locked);
    TEST_ASSERT_FALSE(nf::violations(config, result).empty());
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, result.state_final);
    TEST_ASSERT_FALSE(result.gates_enabled_final);
}

// Of a fault that strikes at a time of the scenario and is found in its tick, before t = 0 as well.
TEST(test_a_fault_has_the_time_that_the_scenario_gives_it)
{
    constexpr double TICK_S = 1e-4;
    for (const double time_s : {-0.012, 0.3}) {
        const Config config = load({fmt::format(
            "scenario.fault=[{{time_s = {}, what = 'overcurrent', value = 19}}]", time_s)});
        const nf::RunResult result = nf::run_scenario(config);
        TEST_ASSERT_EQUAL_size_t(1, result.faults.size());
        TEST_ASSERT_DOUBLE_WITHIN(TICK_S, time_s, result.time_s(result.faults.front()));
        const std::string said = fmt::format(" ({:g} s)", time_s);
        TEST_ASSERT_TRUE(nf::table_text(config, result).find(said) != std::string::npos);
        TEST_ASSERT_TRUE(nf::json_text(config, result).find(said) != std::string::npos);
    }
}

TEST(test_limits_name_what_does_not_hold)
{
    Config config = load();
    config.scenario.accept["ideal"] = {{{"angle_error_max_deg", 0.001}, {"speed_dip_rpm", 10}},
                                       {{"locked", true}, {"limit_cycle", false}}};
    nf::RunResult result = nf::run_scenario(config);
    const std::vector<nf::Violation> found = nf::violations(config, result);
    TEST_ASSERT_EQUAL_size_t(2, found.size());
    TEST_ASSERT_EQUAL_STRING("angle_error_max_deg", found[0].metric.c_str());
    TEST_ASSERT_EQUAL_STRING("0.001", found[0].limit.c_str());
    TEST_ASSERT_EQUAL_STRING("speed_dip_rpm = none, limit: 10", found[1].text().c_str());
    result.metrics.locked = false;
    result.metrics.limit_cycle = true;
    const std::vector<nf::Violation> more = nf::violations(config, result);
    TEST_ASSERT_EQUAL_size_t(4, more.size());
    TEST_ASSERT_EQUAL_STRING("locked = false, limit: true", more[0].text().c_str());
    TEST_ASSERT_EQUAL_STRING("limit_cycle = true, limit: false", more[1].text().c_str());
}

} // namespace
