// SPDX-License-Identifier: MIT
// A sensor of the shaft in whole runs: S4 with each kind, starts under load, the hand-over between
// sensor and observer, and sensors that fail at any instant.
#include "scenario.h"

extern "C" {
#include "transitions.h"
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "testing.h"

namespace
{

using Lines = std::vector<std::string>;

// What the drive was in, and how far its angle was off while the motor ran.
class Watch : public nf::TickSink
{
public:
    explicit Watch(double from_s) : from_s_(from_s)
    {
    }

    void add(const nf::Tick &tick) override
    {
        const drive_t &drive = tick.sim->drive();
        const bool sensed = drive.rotor.source == ESTIMATE_SENSOR;
        states_[transitions_number(drive.state)]++;
        failed_ = failed_ || drive.rotor.failed;
        troubles_ = tick.sim->shaft().troubles;
        trouble_ = tick.sim->shaft().trouble;
        if (drive.state == DRIVE_STATE_RUN && tick.time_s >= from_s_) {
            changes_ += sensed != sensed_ ? 1 : 0;
            largest_deg_ = std::max(largest_deg_, std::abs(nf::angle_error_deg(tick)));
        }
        sensed_ = sensed;
        if (drive.state == DRIVE_STATE_RUN) {
            constexpr double DEG = 180 / 3.14159265358979;
            fastest_rpm_ = std::max(fastest_rpm_, std::abs(tick.truth.omega_mech_rad_s) * DEG / 6);
            farthest_deg_ = std::max(farthest_deg_, std::abs(tick.truth.theta_mech_rad) * DEG);
        }
        speed_rpm_ = tick.truth.omega_mech_rad_s * 30 / 3.14159265358979;
    }

    int64_t ticks_in(drive_state_t state) const
    {
        return states_[transitions_number(state)];
    }
    double largest_deg() const
    {
        return largest_deg_;
    }
    int changes() const
    {
        return changes_;
    }
    bool failed() const
    {
        return failed_;
    }
    uint32_t troubles() const
    {
        return troubles_;
    }
    uint8_t trouble() const
    {
        return trouble_;
    }
    // in RUN; from angle 0, in degrees of the shaft
    double fastest_rpm() const
    {
        return fastest_rpm_;
    }
    double farthest_deg() const
    {
        return farthest_deg_;
    }
    double speed_rpm() const
    {
        return speed_rpm_;
    }

private:
    double from_s_;
    int64_t states_[DRIVE_STATES] = {};
    double largest_deg_ = 0;
    int changes_ = 0;
    bool sensed_ = false;
    bool failed_ = false;
    uint32_t troubles_ = 0;
    uint8_t trouble_ = 0;
    double speed_rpm_ = 0;
    double fastest_rpm_ = 0;
    double farthest_deg_ = 0;
};

struct Outcome {
    nf::Config config;
    nf::RunResult result;
    Watch watch;
};

Outcome run(const nf::Config &config, double from_s = 0)
{
    Outcome one{config, {}, Watch(from_s)};
    nf::RunOptions options;
    options.sink = &one.watch;
    one.result = nf::run_scenario(one.config, options);
    return one;
}

// Both sources: half of the continuous current is enough to align a rotor without load.
Lines both(const std::string &kind, double observer_above_pct)
{
    return {"drive.angle_source=both", "startup.current_pct=50", "sensor.kind=" + kind,
            fmt::format("drive.observer_above_pct={}", observer_above_pct)};
}

Outcome s4(const Lines &set)
{
    return run(nf::load_scenario("s4", {}, set));
}

double figure(const Outcome &one, const char *name)
{
    const auto value = nf::figure(one.result, name);
    TEST_ASSERT_TRUE_MESSAGE(value.has_value(), name);
    return *value;
}

void expect_at_most(double limit, double value, const std::string &what)
{
    const std::string text = fmt::format("{}: {:.4g}, at most {:.4g}", what, value, limit);
    std::printf("%s\n", text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(value <= limit, text.c_str());
}

void expect_no_fault(const Outcome &one, const std::string &what)
{
    for (const nf::FoundFault &fault : one.result.faults) {
        TEST_FAIL_MESSAGE(fmt::format("{}: fault {} at {:.4f} s", what, static_cast<int>(fault.id),
                                      one.result.time_s(fault))
                              .c_str());
    }
}

// S4 with the sensor at every speed, against S4 with the ideal angle. The angle itself is as good
// as the sensor and its alignment: a count is 0.18° of an electrical turn.
TEST(s4_with_an_encoder_or_an_absolute_sensor_is_as_with_the_ideal_angle)
{
    constexpr double SHARE = 1.2;
    constexpr double COUNT_DEG = 360.0 * 2 / 4096;
    const Outcome ideal = s4({});
    for (const char *kind : {"encoder", "encoder_index", "absolute"}) {
        const Outcome one = s4(both(kind, 0));
        expect_no_fault(one, kind);
        for (const char *name : {"speed_error_max_pct", "speed_error_rms_rpm", "speed_dip_rpm",
                                 "recovery_time_s", "command_error_settled_pct"}) {
            expect_at_most(SHARE * figure(ideal, name), figure(one, name), name);
        }
        // 0.02 A is what S4 allows, two counts of the converter.
        expect_at_most(SHARE * 0.02, figure(one, "id_settled_a"), kind);
        expect_at_most(2.5 * COUNT_DEG, figure(one, "angle_error_max_deg"), kind);
        TEST_ASSERT_FALSE(one.watch.failed());
    }
}

// Motor B's rated current is 4.2 A.
TEST(s4_with_hall_sensors_holds_speed_and_current)
{
    constexpr double RATED_A = 4.2;
    const Outcome one = s4(both("hall", -1));
    expect_no_fault(one, "hall");
    expect_at_most(2, figure(one, "speed_error_max_pct"), "speed");
    expect_at_most(0.03 * RATED_A, figure(one, "id_settled_a"), "i_d");
    TEST_ASSERT_EQUAL_INT64(0, one.watch.ticks_in(DRIVE_STATE_HOLD));
}

// At every speed, without the observer, and with edges that lie up to 5° off even ones.
TEST(s4_with_hall_sensors_alone_holds_speed_and_current)
{
    constexpr double RATED_A = 4.2;
    const Lines placements[] = {{}, {"sensor.hall_edges_deg=[4,57,124,176,243,299]"}};
    for (const Lines &placement : placements) {
        Lines set = both("hall", 0);
        set.insert(set.end(), placement.begin(), placement.end());
        const Outcome one = s4(set);
        expect_no_fault(one, "hall");
        expect_at_most(2, figure(one, "speed_error_max_pct"), "speed");
        expect_at_most(0.03 * RATED_A, figure(one, "id_settled_a"), "i_d");
        TEST_ASSERT_EQUAL_INT64(0, one.watch.ticks_in(DRIVE_STATE_HOLD));
    }
}

double between(std::mt19937 &random, double low, double high)
{
    return std::exp(std::uniform_real_distribution<>(std::log(low), std::log(high))(random));
}

// A motor of another size and speed, whose Hall sensors lie anywhere and have edges up to 5° off
// even ones. Its voltages, currents and time constants are not those of motor B. The load takes the
// speed down by as much as in S4, 1.6 %, in the time of a sector and of 32 ticks: by so much the
// tracking loop lags behind any sensor.
nf::Config random_hall_motor(std::mt19937 &random, double *rated_a)
{
    const int pole_pairs = std::uniform_int_distribution<>(1, 11)(random);
    const double el_rad_s = between(random, 150, 1500);
    const double rpm = el_rad_s / pole_pairs * 30 / 3.14159265358979;
    const double flux = between(random, 100, 140) / el_rad_s;
    const double ampere = between(random, 2, 8);
    const double torque = 1.5 * pole_pairs * flux * ampere;
    const double resistance = between(random, 0.02, 0.06) * flux * el_rad_s / ampere;
    const double inductance = between(random, 0.1, 0.3) * flux / ampere;
    const double slowing = 0.016 * el_rad_s / (3.14159265358979 / 3 / el_rad_s + 32 * 100e-6);
    const double inertia = 0.75 * torque * pole_pairs / slowing;
    const double first_deg = std::uniform_real_distribution<>(0, 360)(random);
    std::string edges;
    for (int k = 0; k < 6; k++) {
        const double off_deg = std::uniform_real_distribution<>(-5, 5)(random);
        edges += fmt::format("{}{:.3f}", k == 0 ? "" : ",", first_deg + 60 * k + off_deg);
    }
    *rated_a = ampere;
    nf::Config config = nf::load_parts("motor_b", "bench_310v", "any", {},
                                       {"drive.angle_source=both", "startup.current_pct=50",
                                        "sensor.kind=hall", "drive.observer_above_pct=0",
                                        fmt::format("motor.pole_pairs={}", pole_pairs),
                                        fmt::format("motor.resistance_ohm={}", resistance),
                                        fmt::format("motor.inductance_d_h={}", inductance),
                                        fmt::format("motor.inductance_q_h={}", inductance),
                                        fmt::format("motor.flux_linkage_wb={}", flux),
                                        fmt::format("motor.rated_torque_nm={}", torque),
                                        fmt::format("motor.rated_speed_rpm={}", rpm),
                                        fmt::format("motor.max_speed_rpm={}", 1.2 * rpm),
                                        fmt::format("motor.max_current_a={}", 1.5 * ampere),
                                        fmt::format("motor.inertia_kg_m2={}", inertia),
                                        fmt::format("sensor.hall_edges_deg=[{}]", edges)});
    config.scenario = nf::load_scenario("s1", {}, {}).scenario;
    config.scenario.initial_angle_el_deg = std::uniform_real_distribution<>(0, 360)(random);
    config.scenario.prelude_s = 2;
    config.scenario.duration_s = 1;
    config.scenario.command = {{-1.9, rpm}};
    config.scenario.load = {{0.1, 0.75 * torque}};
    return config;
}

TEST(hall_sensors_alone_hold_speed_and_current_of_motors_of_any_size)
{
    const unsigned runs = testing_runs(3, 60);
    std::mt19937 random(7);
    double largest_pct = 0;
    double largest_share = 0;
    for (unsigned k = 0; k < runs; k++) {
        double rated_a = 0;
        const Outcome one = run(random_hall_motor(random, &rated_a));
        const std::string what = fmt::format("motor {}", k);
        expect_no_fault(one, what);
        expect_at_most(2, figure(one, "speed_error_max_pct"), what + ", speed");
        expect_at_most(0.03 * rated_a, figure(one, "id_settled_a"), what + ", i_d");
        largest_pct = std::max(largest_pct, figure(one, "speed_error_max_pct"));
        largest_share = std::max(largest_share, figure(one, "id_settled_a") / rated_a);
    }
    std::printf("%u motors: speed %.2f %%, i_d %.2f %% of rated current\n", runs, largest_pct,
                100 * largest_share);
}

// A sensor whose angle is half a turn off from the start on, against no load: the torque turns the
// motor the other way, and faster and faster. The EMF shows it before the rotor has gone a turn.
TEST(a_sensor_that_is_turned_is_named_before_the_motor_runs_away)
{
    const struct {
        const char *motor;
        const char *board;
        double rpm;
        double off_deg; // of the shaft
    } rows[] = {{"motor_b", "bench_310v", 1200, 90},
                {"motor_b", "bench_310v", -1200, 75},
                {"outrunner_24v", "b_g431b_esc1", 4000, 180.0 / 7},
                {"outrunner_24v", "b_g431b_esc1", 4000, 210.0 / 7}};
    for (const auto &row : rows) {
        nf::Config config =
            nf::load_parts(row.motor, row.board, "any", {}, {"drive.angle_source=sensor"});
        nf::FaultEntry entry{};
        entry.kind = nf::FaultKind::angle_offset;
        entry.time_s = 0;
        entry.span = nf::FaultSpan::lasting;
        entry.value = row.off_deg;
        config.scenario = nf::load_scenario("s1", {}, {}).scenario;
        config.scenario.prelude_s = 0;
        config.scenario.duration_s = 1;
        config.scenario.command = {{0.1, row.rpm}};
        config.scenario.load = {};
        config.scenario.faults = {entry};
        const Outcome one = run(config);
        const std::string what = fmt::format("{} {:.0f}° off", row.motor, row.off_deg);
        std::printf("%s: %.0f rpm, %.1f° of the shaft\n", what.c_str(), one.watch.fastest_rpm(),
                    one.watch.farthest_deg());
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_ANGLE_SENSOR,
                                      static_cast<int>(one.result.faults.at(0).id), what.c_str());
        expect_at_most(0.4 * std::abs(row.rpm), one.watch.fastest_rpm(), what);
        expect_at_most(90, one.watch.farthest_deg(), what);
    }
}

// Against a friction of half the rated torque; no current is imposed. The angle of Hall sensors is
// up to 30° off until the first edges.
TEST(a_sensor_that_knows_the_angle_starts_an_outrunner_under_load_with_torque)
{
    for (const char *kind : {"hall", "absolute"}) {
        for (const char *angle : {"0", "75", "150", "255", "330"}) {
            nf::Config config =
                nf::load_parts("outrunner_24v", "b_g431b_esc1", "any", {},
                               {"drive.angle_source=both", fmt::format("sensor.kind={}", kind),
                                "plant.coulomb_friction_nm=0.3"});
            config.scenario = nf::load_scenario("s1", {}, {}).scenario;
            config.scenario.initial_angle_el_deg = std::stod(angle);
            config.scenario.command = {{0.05, 2000}};
            config.scenario.load = {};
            config.scenario.duration_s = 1;
            const Outcome one = run(config);
            expect_no_fault(one, fmt::format("{} from {}°", kind, angle));
            TEST_ASSERT_EQUAL_INT64(0, one.watch.ticks_in(DRIVE_STATE_ALIGN));
            TEST_ASSERT_EQUAL_INT64(0, one.watch.ticks_in(DRIVE_STATE_HOLD));
            TEST_ASSERT_DOUBLE_WITHIN(40, 2000, one.watch.speed_rpm()); // 2 %
        }
    }
}

// From above the hand-over down and up again: two changes. θ̂ is never further off than sensor and
// observer are by themselves.
TEST(the_hand_over_by_speed_is_without_a_jump_of_the_angle)
{
    const struct {
        const char *kind;
        double largest_deg;
    } rows[] = {{"encoder", 0.6}, {"absolute", 0.2}, {"hall", 12}};
    for (const auto &row : rows) {
        nf::Config config = nf::load_scenario("s4", {}, both(row.kind, 40));
        config.scenario.command = {{-2, 900}, {0, 200}, {1.5, 900}};
        config.scenario.load = {};
        config.scenario.duration_s = 3;
        const Outcome one = run(config, -1);
        expect_no_fault(one, row.kind);
        TEST_ASSERT_GREATER_OR_EQUAL_INT_MESSAGE(2, one.watch.changes(), row.kind);
        expect_at_most(row.largest_deg, one.watch.largest_deg(), row.kind);
    }
}

struct Failure {
    const char *kind;
    nf::FaultKind fault;
    double value;
};

// A sensor that fails for good.
const Failure FAILURES[] = {
    {"hall", nf::FaultKind::sensor_high, 7},         // its supply: the wires are pulled up
    {"hall", nf::FaultKind::sensor_low, 7},          // shorted
    {"hall", nf::FaultKind::angle_stuck, 0},         //
    {"hall", nf::FaultKind::sensor_high, 1},         // one wire
    {"hall", nf::FaultKind::sensor_low, 2},          //
    {"absolute", nf::FaultKind::sensor_high, 65535}, //
    {"absolute", nf::FaultKind::sensor_low, 65535},  //
    {"absolute", nf::FaultKind::sensor_flipped, 16}, // parity
    {"absolute", nf::FaultKind::angle_stuck, 0},     //
    {"encoder", nf::FaultKind::angle_stuck, 0},      //
    {"encoder_index", nf::FaultKind::encoder_slip, 300},
};

nf::Config failing(const Failure &failure, double at_s, double rpm, double load_nm)
{
    const bool hall = std::string(failure.kind) == "hall";
    nf::Config config = nf::load_scenario("s4", {}, both(failure.kind, hall ? nf::BY_KIND : 0));
    nf::FaultEntry entry{};
    entry.kind = failure.fault;
    entry.time_s = at_s;
    entry.span = nf::FaultSpan::lasting;
    entry.value = failure.value;
    config.scenario.command = {{-2, rpm}};
    config.scenario.load = {{-0.5, load_nm}};
    config.scenario.faults = {entry};
    config.scenario.duration_s = 1;
    return config;
}

// An encoder or an absolute sensor drives at any speed here, and the observer takes over in the
// tick in which it fails. With Hall sensors the observer drives already. The motor holds its speed,
// and the trouble has a name.
TEST(a_sensor_that_fails_at_speed_leaves_the_motor_running)
{
    const unsigned runs = testing_runs(11, 2200);
    std::mt19937 random(1);
    for (unsigned k = 0; k < runs; k++) {
        const Failure &failure = FAILURES[k % (sizeof FAILURES / sizeof FAILURES[0])];
        const double at_s = std::uniform_real_distribution<>(0, 0.3)(random);
        const double rpm = std::uniform_real_distribution<>(700, 1300)(random);
        const double load_nm = std::uniform_real_distribution<>(0, 3)(random);
        const Outcome one = run(failing(failure, at_s, rpm, load_nm));
        const std::string what =
            fmt::format("run {}: {} fault {} at {:.4f} s, {:.0f} rpm, {:.2f} N·m", k, failure.kind,
                        static_cast<int>(failure.fault), at_s, rpm, load_nm);
        expect_no_fault(one, what);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.03 * rpm, rpm, one.watch.speed_rpm(), what.c_str());
        TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(0, one.watch.troubles(), what.c_str());
    }
}

} // namespace
