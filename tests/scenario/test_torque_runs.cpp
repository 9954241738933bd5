// SPDX-License-Identifier: MIT
// Torque control in whole runs: how true the torque is at a speed, the ends of the window, the way
// through the start-up, and changes between the three modes at any time.
#include "run_bench.h"
#include "voltage_drive_units.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using nf::Machine;
using nf::Words;
using Bench = nf::RunBench;

constexpr Machine MOTOR_A = {"motor_a", "bench_310v", "robust_motor_a"};

// Beyond this angle error the torque has the wrong sign.
constexpr double LOST_DEG = 90;

// ---- the torque at a speed

// Rotors: what 6 % of the rated torque takes the speed off in half a second is then a hundredth of
// rated speed, for motor A.
constexpr double BENCH_INERTIA = 40;
constexpr double ABOVE_HANDOVER = 0.2; // which is at 10 % of rated speed
constexpr double IDEAL_PCT = 3;
constexpr double ALL_PCT = 6;

// How far the torque is off the command, in percent of it, where a load as large holds the speed. A
// mean over 0.3 s: many periods of what the dead time makes.
double off_pct(const Words &sets, double speed, double torque, const Words &more)
{
    Words set = more;
    set.push_back(fmt::format("motor.inertia_kg_m2={}", 0.003 * BENCH_INERTIA));
    set.insert(set.end(), {"speed_loop.bandwidth_hz=5", "speed_loop.ramp_rpm_s=2000",
                           "torque_loop.slope_nm_s=500"});
    Bench bench(MOTOR_A, sets, set);
    bench.ask_speed(std::max(speed, ABOVE_HANDOVER));
    bench.until(DRIVE_STATE_RUN, 20);
    bench.ask_speed(speed);
    bench.seconds(2);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, speed,
                              bench.mean_speed(0.3)); // some ripples of the bus swing it
    bench.load(torque);
    bench.ask_torque(torque);
    bench.seconds(0.2);
    const double mean = bench.mean_torque(0.3);
    const std::string what =
        fmt::format("{} at {:.0f} % of rated speed, {:+.0f} % torque",
                    sets.empty() ? "ideal" : sets.front(), 100 * speed, 100 * torque);
    TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(bench.torque_is_free(), what.c_str());
    TEST_ASSERT_DOUBLE_WITHIN(0.05, speed, bench.speed());
    const double off = 100 * std::abs(mean / torque - 1);
    fmt::print("{}: {:.2f} % off\n", what, off);
    return off;
}

TEST(test_the_torque_is_what_was_asked_for_at_each_speed)
{
    for (const double torque : {0.5, -0.5, 0.9}) {
        for (const double speed : {0.1, 0.5, 1.0}) {
            TEST_ASSERT_TRUE(off_pct({}, speed, torque, {}) < IDEAL_PCT);
            TEST_ASSERT_TRUE(off_pct({"all"}, speed, torque, {}) < ALL_PCT);
        }
    }
}

// Without a sensor the angle is not known there: the torque is that of the imposed vector, what the
// load takes.
TEST(test_with_a_sensor_the_torque_is_what_was_asked_for_at_standstill)
{
    const Words sensor = {"drive.angle_source=sensor"};
    for (const double torque : {0.5, -0.5}) {
        TEST_ASSERT_TRUE(off_pct({}, 0, torque, sensor) < IDEAL_PCT);
        TEST_ASSERT_TRUE(off_pct({"all"}, 0, torque, sensor) < ALL_PCT);
    }
}

// ---- the window

// Nothing loads the motor, and it asks for its largest torque: the hardest landing. It comes to
// rest at the end of the window.
void land(const Machine &machine, double sign, double end)
{
    const nf::Config plain = nf::load_parts(machine.motor, machine.board, machine.tuning, {}, {});
    const double end_rpm = end * plain.motor.rated_speed_rpm;
    Bench bench(machine, {},
                {fmt::format("torque_loop.speed_forward_rpm={}", end_rpm),
                 fmt::format("torque_loop.speed_backward_rpm={}", end_rpm)});
    const std::string what = fmt::format("{} to {:+.2f}", machine.motor, sign * end);
    double furthest = 0;
    bench.ask_torque(2 * sign);
    bench.until(DRIVE_STATE_RUN, 10);
    for (int k = 0; k < 3000; k++) {
        bench.slow_period();
        furthest = std::max(furthest, sign * bench.speed());
    }
    fmt::print("{}: furthest {:.4f}, in the end {:.4f}\n", what, furthest, bench.speed());
    TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, what.c_str());
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.005, end, sign * bench.speed(), what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(furthest < end + 0.03, what.c_str());
    // And back: the other torque acts as soon as the slope lets it.
    const nf::TuningSettings tuning =
        nf::settled_tuning(plain.motor, plain.board, plain.tuning, plain.model);
    bench.ask_torque(-0.5 * sign);
    bench.seconds(0.5 * plain.motor.rated_torque_nm / tuning.torque_slope_nm_s + 0.01);
    TEST_ASSERT_TRUE_MESSAGE(sign * bench.mean_torque(0.01) < -0.4, what.c_str());
}

constexpr Machine MACHINES[] = {MOTOR_A,
                                {"motor_b", "bench_310v", "any"},
                                {"odrive_d5065", "b_g431b_esc1", "any"},
                                {"teknic_m2310p", "frdm_mc_lvpmsm", "any"}};

TEST(test_at_an_end_of_the_window_the_rotor_comes_to_rest)
{
    for (const Machine &machine : MACHINES) {
        land(machine, 1, 0.8);
        land(machine, -1, 0.5);
    }
}

// ---- the start-up

// Each state once on the way, none twice: it does not come and go at a border.
TEST(test_a_torque_goes_through_the_start_up_and_back_to_a_standstill)
{
    for (const Machine &machine : MACHINES) {
        Bench bench(machine, {}, {});
        std::vector<int> states;
        const auto follow = [&](double time_s) {
            const long ticks = std::lround(time_s / bench.sim.bases().control_period_s);
            for (long k = 0; k < ticks; k++) {
                bench.tick();
                const int state = bench.sim.drive().state;
                if (states.empty() || states.back() != state) {
                    states.push_back(state);
                }
            }
        };
        bench.ask_torque(0);
        bench.until(DRIVE_STATE_HOLD, 10);
        bench.ask_torque(0.3);
        follow(1.5);
        bench.ask_torque(-0.3);
        follow(3);
        bench.ask_torque(0);
        follow(0.1);
        bench.ask_torque(0.3);
        follow(0.05);
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, machine.motor);
        const std::vector<int> expected = {
            DRIVE_STATE_HOLD, DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN,
            DRIVE_STATE_HOLD, DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN};
        std::string seen;
        for (const int state : states) {
            seen += fmt::format("{} ", state);
        }
        fmt::print("{}: states {}\n", machine.motor, seen);
        TEST_ASSERT_TRUE_MESSAGE(states.size() >= expected.size(), seen.c_str());
        for (std::size_t k = 0; k < expected.size(); k++) {
            TEST_ASSERT_EQUAL_INT_MESSAGE(expected[k], states[k], seen.c_str());
        }
    }
}

// A gimbal motor, hot: its R·i is three times the EMF, and 0.2 s of its rated torque bring it to
// rated speed. What an observer can find from its error is too slow there: without the torque that
// leads it, the angle was off by 100° to 180°. The furthest it is off in RUN, in three reversals
// through standstill.
double reversed_deg(double torque, const Words &set)
{
    Bench bench(nf::load_scenario("zoo:gimbal:14@1", {"hot"}, set));
    const std::string what = fmt::format("{:+.1f} of the torque, {}", torque, fmt::join(set, " "));
    double worst = 0;
    bench.ask_torque(torque);
    bench.until(DRIVE_STATE_RUN, 5);
    for (int k = 0; k < 3; k++) {
        bench.seconds(1);
        bench.ask_torque(k % 2 == 0 ? -torque : torque);
        for (double t = 0; t < 1; t += bench.sim.bases().control_period_s) {
            bench.tick();
            if (bench.sim.drive().state == DRIVE_STATE_RUN) {
                worst = std::max(worst, std::abs(nf::angle_error_deg(bench.now)));
            }
        }
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, what.c_str());
        TEST_ASSERT_TRUE_MESSAGE((k % 2 == 0 ? -torque : torque) * bench.speed() > 0, what.c_str());
    }
    fmt::print("{}: {:.1f}° off\n", what, worst);
    return worst;
}

TEST(test_a_reversal_of_the_torque_keeps_the_angle_of_a_gimbal_motor)
{
    constexpr double WRONG_INERTIA_DEG =
        45; // 25.5° and 37.1°: the torque leads by twice of what it does, or by half
    constexpr double KEPT_DEG =
        25; // 19.4° with the friction, where the rotor stops sooner than its torque says
    for (const double share : {0.999, 0.9995, 1.0, 1.0005, 1.001}) {
        const std::string inertia = fmt::format("motor.inertia_kg_m2={}", 8.767e-5 * share);
        TEST_ASSERT_TRUE(reversed_deg(1, {inertia}) < KEPT_DEG);
        TEST_ASSERT_TRUE(reversed_deg(-1, {inertia, "plant.coulomb_friction_nm=0.02"}) < KEPT_DEG);
    }
    TEST_ASSERT_TRUE(reversed_deg(0.3, {}) < KEPT_DEG);
    for (const char *const wrong : {"plant.inertia_scale=2", "plant.inertia_scale=0.5"}) {
        TEST_ASSERT_TRUE(reversed_deg(1, {wrong}) < WRONG_INERTIA_DEG);
    }
}

// A load above the torque slows the rotor down to the lowest speed of RUN, and does not turn it
// back.
TEST(test_a_load_above_the_torque_ends_at_the_lowest_speed)
{
    Bench bench(MOTOR_A, {}, {});
    bench.ask_torque(0.5);
    bench.until(DRIVE_STATE_RUN, 5);
    bench.load(0.6);
    bench.seconds(2);
    fmt::print("0.5 of the torque, 0.6 of load: {:.4f} of the speed\n", bench.speed());
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, bench.sim.drive().fault.id);
    TEST_ASSERT_TRUE(bench.speed() > 0.01);
    TEST_ASSERT_TRUE(bench.speed() < 0.1);
    bench.load(0.2);
    bench.seconds(0.5);
    TEST_ASSERT_TRUE(bench.speed() > 0.3);
}

// A friction that is more than the torque: the speed loop holds the lowest speed of RUN, whatever
// the noise, and nothing starts anew.
void rest_at_the_lowest_speed(const Machine &machine, const Words &set, double torque,
                              double friction)
{
    const nf::Config plain = nf::load_parts(machine.motor, machine.board, machine.tuning, {}, set);
    Words more = set;
    more.push_back(
        fmt::format("plant.coulomb_friction_nm={}", friction * plain.motor.rated_torque_nm));
    Bench bench(machine, {"adc"}, more);
    const double lowest = bench.sim.bases().rpm_from_step(bench.sim.cfg().startup.hold_speed) /
                          plain.motor.rated_speed_rpm;
    const std::string what =
        fmt::format("{}, {:+} of the torque, {} of friction", machine.motor, torque, friction);
    bench.ask_torque(torque);
    bench.until(DRIVE_STATE_RUN, 5);
    bench.seconds(0.5);
    double slowest = 1;
    double fastest = 0;
    const double period_s = bench.sim.cfg().slow_ticks * bench.sim.bases().control_period_s;
    for (long k = std::lround(2 / period_s); k > 0; k--) {
        bench.slow_period();
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_STATE_RUN, bench.sim.drive().state, what.c_str());
        slowest = std::min(slowest, std::abs(bench.speed()));
        fastest = std::max(fastest, std::abs(bench.speed()));
    }
    fmt::print("{}: {:.4f} to {:.4f}, lowest speed {:.4f}\n", what, slowest, fastest, lowest);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.05 * lowest, lowest, slowest, what.c_str());
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.05 * lowest, lowest, fastest, what.c_str());
}

// Of a skateboard: little inertia, and friction that is most of its rated torque.
const Words OUTRUNNER = {"motor.pole_pairs=7",
                         "motor.resistance_ohm=0.021",
                         "motor.inductance_d_h=24e-6",
                         "motor.inductance_q_h=31e-6",
                         "motor.flux_linkage_wb=0.00414",
                         "motor.rated_torque_nm=2.2",
                         "motor.rated_speed_rpm=5000",
                         "motor.max_speed_rpm=6000",
                         "motor.max_current_a=90",
                         "motor.continuous_current_a=50",
                         "motor.inertia_kg_m2=4e-4",
                         "motor.viscous_friction_nm_s=1e-4",
                         "board.pwm_frequency_hz=25000",
                         "board.current_full_scale_a=165",
                         "board.overcurrent_a=140",
                         "board.trip_a=160",
                         "board.offset_max_a=8",
                         "board.bus_full_scale_v=72",
                         "board.bus_nominal_v=48",
                         "board.bus_min_v=30",
                         "board.bus_max_v=60",
                         "board.duty_margin_pct=6",
                         "board.dead_time_s=0.36e-6",
                         "board.device_drop_v=0.02"};

TEST(test_a_torque_below_the_friction_rests_at_the_lowest_speed)
{
    rest_at_the_lowest_speed({"motor_a", "bench_310v", "any"}, OUTRUNNER, 0.045, 0.9);
    rest_at_the_lowest_speed({"motor_a", "bench_310v", "any"}, OUTRUNNER, -0.8, 0.9);
    for (const Machine &machine : {Machine{"motor_a", "bench_310v", "any"},
                                   Machine{"odrive_d5065", "b_g431b_esc1", "any"}}) {
        rest_at_the_lowest_speed(machine, {}, 0.05, 0.3);
        rest_at_the_lowest_speed(machine, {}, -0.2, 0.8);
    }
}

// ---- changes of the mode

struct Changes {
    int between_runs = 0;     // changes of mode in RUN
    int of_voltage_drive = 0; // of them, those that ended the voltage drive
    double worst = 0;         // change of i_q* in a slow period of a bridge, over that of the slope
    double worst_deg = 0;
};

// Any mode with any target, each for some time from a slow period to `longest_s`.
Changes change_at_random(const Machine &machine, const Words &sets, unsigned seed, double time_s,
                         double longest_s = 0.5)
{
    Bench bench(machine, sets, {});
    std::mt19937 random(seed);
    const auto within = [&](double lowest, double highest) {
        return lowest + (highest - lowest) * static_cast<double>(random()) / 4294967296.0;
    };
    const double period_s = bench.sim.bases().control_period_s * bench.sim.cfg().slow_ticks;
    const drive_t &drive = bench.sim.drive();
    Changes found;
    long left = 0;
    bench.ask_torque(0);
    bench.until(DRIVE_STATE_HOLD, 10);
    for (double t = 0; t < time_s; t += period_s) {
        const int mode = drive.motion.mode;
        const int32_t before = drive.control.current_ref.q;
        const bool by_voltage = drive.voltage_drive.active;
        const bool ran = drive.state == DRIVE_STATE_RUN && !by_voltage;
        const bool bridged = drive.motion.torque_loop.bridging;
        if (--left < 0) {
            left = std::lround(within(0, within(0, longest_s)) / period_s);
            const int next = static_cast<int>(random() % 3);
            if (next == 0) {
                bench.ask_speed(within(-1, 1));
            } else if (next == 1) {
                bench.ask_torque(random() % 4 == 0 ? 0 : within(-1, 1));
            } else {
                bench.sim.command_position_rad(bench.now.truth.theta_mech_rad + within(-10, 10));
            }
        }
        bench.slow_period();
        const std::string what =
            fmt::format("{}, seed {}, {:.3f} s, mode {} to {}, state {}", machine.motor, seed, t,
                        mode, drive.motion.mode, static_cast<int>(drive.state));
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, drive.fault.id, what.c_str());
        if (drive.state == DRIVE_STATE_RUN) {
            found.worst_deg = std::max(found.worst_deg, std::abs(nf::angle_error_deg(bench.now)));
        }
        const bool changes = mode != drive.motion.mode;
        // The voltage drive has no i_q*: it begins with the mean of the current, and the bridge
        // goes on from there.
        found.of_voltage_drive += changes && by_voltage && drive.state == DRIVE_STATE_RUN ? 1 : 0;
        if (!ran || drive.state != DRIVE_STATE_RUN || drive.voltage_drive.active) {
            continue;
        }
        found.between_runs += changes ? 1 : 0;
        // A limit of the current comes before the slope.
        const int32_t now = drive.control.current_ref.q;
        const torque_range_t range = drive.motion.torque_range;
        const bool limited =
            std::max(before, now) >= range.upper || std::min(before, now) <= range.lower;
        if (!limited && (changes || (bridged && drive.motion.torque_loop.bridging))) {
            const int32_t flux = drive_flux(&drive);
            const int32_t slope =
                std::max(current_reference_q(drive.cfg->torque_loop.slope, flux), 1);
            // the reference and its current are rounded, an LSB each
            const double change = std::abs(now - before);
            found.worst = std::max(found.worst, change / (slope + 2));
            TEST_ASSERT_TRUE_MESSAGE(change <= slope + 2, what.c_str());
        }
    }
    return found;
}

TEST(test_the_mode_may_change_at_any_time)
{
    for (const Machine &machine : MACHINES) {
        for (unsigned seed = 1; seed <= testing_runs(1, 3); seed++) {
            const Changes found = change_at_random(machine, {}, seed, 20);
            fmt::print("{}, seed {}: {} changes in RUN, at most {:.2f} of the slope, {:.1f}° off\n",
                       machine.motor, seed, found.between_runs, found.worst, found.worst_deg);
            TEST_ASSERT_TRUE(found.between_runs > 3);
            TEST_ASSERT_TRUE(found.worst_deg < LOST_DEG);
        }
    }
}

// The speed of a voltage drive takes longer to settle, and only then there is one.
TEST(test_the_mode_may_change_at_any_time_with_a_voltage_drive)
{
    constexpr Machine BY_VOLTAGE = {"motor_a", "bench_310v", "voltage_phase"};
    int of_voltage_drive = 0;
    for (const unsigned seed : {21U, 22U, 23U}) {
        const Changes found = change_at_random(BY_VOLTAGE, {}, seed, 120, 12);
        fmt::print(
            "voltage drive, seed {}: {} changes in RUN, {} of a voltage drive, at most {:.2f} of "
            "the slope, {:.1f}° off\n",
            seed, found.between_runs, found.of_voltage_drive, found.worst, found.worst_deg);
        TEST_ASSERT_TRUE(found.worst_deg < LOST_DEG);
        of_voltage_drive += found.of_voltage_drive;
    }
    TEST_ASSERT_TRUE(of_voltage_drive > 3);
}

TEST(test_the_mode_may_change_at_any_time_on_real_hardware)
{
    for (unsigned seed = 11; seed < 11 + testing_runs(1, 3); seed++) {
        const Changes found = change_at_random(MOTOR_A, {"all"}, seed, 20);
        fmt::print(
            "motor_a, all, seed {}: {} changes in RUN, at most {:.2f} of the slope, {:.1f}° off\n",
            seed, found.between_runs, found.worst, found.worst_deg);
        TEST_ASSERT_TRUE(found.between_runs > 3);
        TEST_ASSERT_TRUE(found.worst_deg < LOST_DEG);
    }
}

} // namespace
