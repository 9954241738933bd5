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
