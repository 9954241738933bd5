// SPDX-License-Identifier: MIT
// Beyond base speed, in whole runs: the torque against the largest that current and voltage allow,
// the torque of a current against the largest there is, and a speed that only a weakened field
// reaches.
#include "modulator_units.h"
#include "run_bench.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace
{

using nf::Machine;
using nf::Words;
using Bench = nf::RunBench;

constexpr Machine MACHINES[] = {{"motor_a_weakened", "bench_310v_short", "robust_motor_a"},
                                {"motor_b_weakened", "bench_310v_short", "any"},
                                {"compressor", "compressor_310v", "any"}};
constexpr int DIRECTIONS = 2000;
constexpr double HALF_TURN = 3.14159265358979323846;

double torque_of(const nf::MotorSettings &m, double d, double q)
{
    return 1.5 * m.pole_pairs * (m.flux_linkage_wb + (m.inductance_d_h - m.inductance_q_h) * d) * q;
}

// The voltage that holds these currents at a speed, in rad/s electrical.
double voltage_of(const nf::MotorSettings &m, double omega, double d, double q)
{
    return std::hypot(m.resistance_ohm * d - omega * m.inductance_q_h * q,
                      m.resistance_ohm * q + omega * (m.inductance_d_h * d + m.flux_linkage_wb));
}

// The longest current in a direction (a length of 1) that this voltage holds at this speed: the
// larger root of |length·u + j·emf|² = volts². Not a number where it holds none.
double longest_a(const nf::MotorSettings &m, double omega, double volts, double d, double q)
{
    const double u_d = m.resistance_ohm * d - omega * m.inductance_q_h * q;
    const double u_q = m.resistance_ohm * q + omega * m.inductance_d_h * d;
    const double emf = omega * m.flux_linkage_wb;
    const double square = u_d * u_d + u_q * u_q;
    const double along = u_q * emf;
    return (std::sqrt(along * along - square * (emf * emf - volts * volts)) - along) / square;
}

// The largest torque of all currents within a circle that this voltage holds at this speed. In each
// direction the longest current has the most; where the circle ends before the voltage allows any,
// there is none.
double envelope_nm(const nf::MotorSettings &m, double omega, double volts, double most_a)
{
    constexpr double ROUNDED = 1 + 1e-9;
    double best = 0;
    for (int k = 0; k <= DIRECTIONS; k++) {
        const double angle = HALF_TURN / 2 * k / DIRECTIONS;
        const double length =
            std::min(longest_a(m, omega, volts, -std::sin(angle), std::cos(angle)), most_a);
        const double d = -length * std::sin(angle);
        const double q = length * std::cos(angle);
        if (voltage_of(m, omega, d, q) <= volts * ROUNDED) {
            best = std::max(best, torque_of(m, d, q));
        }
    }
    return best;
}

// ---- the torque-speed curve

// So heavy that the rated torque takes this long to rated speed: in the mean of the torque the
// speed changes by a percent.
constexpr double RISE_S = 6;
constexpr double ENVELOPE_LEAST = 0.97;
// The plant's torque of a mean current: noise is none, and what the converter's steps make is
// within this.
constexpr double ENVELOPE_MOST = 1.005;

void follow_the_curve(const Machine &machine, double sign)
{
    const nf::Config plain = nf::load_parts(machine.motor, machine.board, machine.tuning, {}, {});
    const nf::MotorSettings &motor = plain.motor;
    const double rated_rad_s = nf::rad_s_from_rpm(motor.rated_speed_rpm);
    Bench bench(
        machine, {},
        {fmt::format("motor.inertia_kg_m2={}", motor.rated_torque_nm * RISE_S / rated_rad_s),
         fmt::format("motor.continuous_current_a={}", motor.max_current_a),
         "speed_loop.bandwidth_hz=2"});
    const double volts = nf::largest_ratio(plain.board) * plain.board.bus_nominal_v;
    const double top = 0.95 * motor.max_speed_rpm / motor.rated_speed_rpm;
    bench.ask_torque(3 * sign);
    bench.until(DRIVE_STATE_RUN, 60);
    double next = 0.5;
    for (int k = 0; k < 400 && next < top; k++) {
        const double torque = std::abs(bench.mean_torque(0.05)) * motor.rated_torque_nm;
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, machine.motor);
        const double speed = sign * bench.speed();
        if (speed < next) {
            continue;
        }
        const double omega = nf::rad_s_from_rpm(speed * motor.rated_speed_rpm) * motor.pole_pairs;
        const double share = torque / envelope_nm(motor, omega, volts, motor.max_current_a);
        const std::string what =
            fmt::format("{} at {:+.2f} of rated speed: {:.3f} N·m, {:.2f} % of the largest",
                        machine.motor, sign * speed, torque, 100 * share);
        fmt::print("{}\n", what);
        TEST_ASSERT_TRUE_MESSAGE(share > ENVELOPE_LEAST && share < ENVELOPE_MOST, what.c_str());
        next = speed + 0.1;
    }
    TEST_ASSERT_TRUE_MESSAGE(next >= top, machine.motor);
}

TEST(test_the_largest_torque_is_that_of_current_and_voltage_at_every_speed)
{
    for (const Machine &machine : MACHINES) {
        follow_the_curve(machine, 1);
        follow_the_curve(machine, -1);
    }
}

// ---- torque per ampere

constexpr double PER_AMPERE_LEAST = 0.99;

double most_torque_nm(const nf::MotorSettings &m, double current)
{
    return envelope_nm(m, 0, HUGE_VAL, current);
}

TEST(test_the_salient_motors_have_the_largest_torque_of_their_current)
{
    for (const Machine &machine : {MACHINES[1], MACHINES[2]}) {
        for (const double torque : {0.5, -0.5, 1.0, 1.3}) {
            Bench bench(machine, {}, {});
            bench.ask_speed(0.5);
            bench.until(DRIVE_STATE_RUN, 20);
            bench.seconds(1);
            bench.load(torque);
            bench.seconds(1);
            const double made = bench.mean_torque(0.2) * bench.config.motor.rated_torque_nm;
            const plant_view_t &truth = bench.now.truth;
            const double share =
                std::abs(made) /
                most_torque_nm(bench.config.motor, std::hypot(truth.i_d_a, truth.i_q_a));
            const std::string what =
                fmt::format("{}, {:+.0f} % of rated torque: {:.2f} % of the largest of its current",
                            machine.motor, 100 * torque, 100 * share);
            fmt::print("{}\n", what);
            TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, what.c_str());
            TEST_ASSERT_TRUE_MESSAGE(share > PER_AMPERE_LEAST, what.c_str());
        }
    }
}

// ---- speed beyond the base

constexpr double ANGLE_MOST_DEG = 3;
// `imp` on the compressor: X_q·i_q is as large as the EMF there, and the drive believes L −20 %
// until it has measured it.
constexpr double ANGLE_SALIENT_DEG = 6;
constexpr double SPEED_WITHIN = 0.01;
// Behind a rectifier nothing takes energy back: what this capacitor cannot hold a rotor loses in
// its winding and by friction.
const Words CAPACITOR = {"plant.bus_capacitance_f=0.001"};
constexpr int PATIENCE_S = 60;

// From a standstill to the speed, under a load there, and to the same speed the other way.
void run_beyond_base(const Machine &machine, const Words &sets, const Words &bus, double rpm,
                     double load_nm, double angle_deg)
{
    Bench bench(machine, sets, bus);
    const double rated = bench.config.motor.rated_speed_rpm;
    const std::string what =
        fmt::format("{}, {} at {} rpm", machine.motor, sets.empty() ? "ideal" : sets.front(), rpm);
    double worst_deg = 0;
    double bus_v = 0;
    const auto pass = [&](double time_s) {
        const long ticks = std::lround(time_s / bench.sim.bases().control_period_s);
        for (long k = 0; k < ticks; k++) {
            bench.tick();
            bus_v = std::max(bus_v, bench.now.truth.bus_v);
            if (std::abs(bench.speed()) > 0.5) {
                worst_deg = std::max(worst_deg, std::abs(nf::angle_error_deg(bench.now)));
            }
        }
    };
    bench.ask_speed(0);
    bench.until(DRIVE_STATE_HOLD, 20);
    for (const double sign : {1.0, -1.0}) {
        bench.ask_speed(sign * rpm / rated);
        for (int k = 0; k < PATIENCE_S && sign * bench.speed() < (1 - SPEED_WITHIN) * rpm / rated;
             k++) {
            pass(1);
        }
        pass(1);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SPEED_WITHIN * rpm / rated, sign * rpm / rated,
                                          bench.speed(), what.c_str());
        bench.sim.set_load_nm(sign * load_nm);
        pass(2);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SPEED_WITHIN * rpm / rated, sign * rpm / rated,
                                          bench.speed(), what.c_str());
        bench.sim.set_load_nm(0);
        pass(1);
    }
    fmt::print("{}: angle within {:.2f}°, bus {:.1f} V\n", what, worst_deg, bus_v);
    TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, bench.sim.drive().fault.id, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(worst_deg < angle_deg, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(bus_v < bench.config.board.bus_max_v, what.c_str());
}

TEST(test_a_weakened_field_holds_a_speed_that_the_emf_forbids)
{
    for (const Words &sets : {Words{}, Words{"all"}, Words{"imp"}}) {
        run_beyond_base(MACHINES[0], sets, CAPACITOR, 2600, 3, ANGLE_MOST_DEG);
        run_beyond_base(MACHINES[1], sets, {}, 2300, 1, ANGLE_MOST_DEG);
        run_beyond_base(MACHINES[2], sets, {}, 6500, 0.8, ANGLE_SALIENT_DEG);
    }
}

} // namespace
