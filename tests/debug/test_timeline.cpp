// SPDX-License-Identifier: MIT
// Forwards and backwards through a run: always to the same bits, never far from a snapshot, in
// bounded memory.
#include "diff.h"
#include "set.h"
#include "timeline.h"

extern "C" {
#include "drive_words.h"
}

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "testing.h"

using nf::debug::set_signal;
using nf::debug::Span;
using nf::debug::Timeline;

static constexpr int64_t FIRST = 3000;

// Drive and motor: whatever one of them does otherwise is in the other a tick later.
struct Mark {
    uint32_t drive;
    plant_view_t motor;

    explicit Mark(const Timeline &timeline)
        : drive(drive_words_hash(&timeline.run().sim().drive())), motor(timeline.tick().truth)
    {
    }
    bool operator==(const Mark &other) const
    {
        return drive == other.drive && std::memcmp(&motor, &other.motor, sizeof motor) == 0;
    }
};

TEST(test_ten_thousand_ticks_forth_and_back_end_in_the_same_state)
{
    // Noise and a fault in it, so that the random numbers and the script have to come back as well.
    const nf::Config config = nf::load_scenario(
        "s1_robust", {"all"}, {R"(scenario.fault=[{time_s=0.3, what="phase_a_open"}])"});
    Timeline timeline(config);
    timeline.go_to(FIRST);
    std::vector<Mark> forth;
    for (int k = 0; k < 10000; k++) {
        forth.emplace_back(timeline);
        TEST_ASSERT_TRUE(timeline.step());
    }
    TEST_ASSERT_EQUAL_UINT32(DRIVE_STATE_FAULT, timeline.run().sim().drive().state);
    const Mark there(timeline);

    // Each tick costs up to 1024 to get back to; a stride that hits every part of a spacing.
    constexpr int64_t STRIDE = 37;
    for (int64_t k = 9999; k >= 0; k -= STRIDE) {
        timeline.go_to(FIRST + k);
        TEST_ASSERT_TRUE(Mark(timeline) == forth[static_cast<std::size_t>(k)]);
    }
    timeline.go_to(FIRST);
    TEST_ASSERT_TRUE(Mark(timeline) == forth[0]);
    for (int k = 0; k < 10000; k++) {
        TEST_ASSERT_TRUE(Mark(timeline) == forth[static_cast<std::size_t>(k)]);
        TEST_ASSERT_TRUE(timeline.step());
    }
    TEST_ASSERT_TRUE(Mark(timeline) == there);
}

TEST(test_a_run_is_that_of_the_scenario)
{
    const nf::Config config = nf::load_scenario("s3_robust", {"imp"});
    Timeline timeline(config);
    nf::ScriptedRun run(config);
    timeline.go_to(timeline.last());
    timeline.go_to(5000);
    timeline.go_to(timeline.last());
    while (run.tick() < run.end() - 1) {
        (void)run.control();
        run.advance();
    }
    (void)run.control();
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.sim().drive()),
                            drive_words_hash(&timeline.run().sim().drive()));
}

TEST(test_the_ends_of_a_run_stop)
{
    const nf::Config config = nf::load_scenario("s1", {}, {"scenario.duration_s=0.01"});
    Timeline timeline(config);
    timeline.go_to(timeline.last());
    TEST_ASSERT_FALSE(timeline.step());
    TEST_ASSERT_EQUAL_INT64(timeline.last(), timeline.now());
    timeline.go_to(0);
    TEST_ASSERT_EQUAL_INT64(0, timeline.now());
}

// 10 s and 60 s.
static void check_reach(double duration_s, int64_t farthest)
{
    const nf::Config config =
        nf::load_scenario("s1_robust", {}, {"scenario.duration_s=" + std::to_string(duration_s)});
    Timeline timeline(config);
    timeline.go_to(timeline.last());
    TEST_ASSERT_TRUE(timeline.snapshots() <= Timeline::SNAPSHOTS_MAX);
    TEST_ASSERT_TRUE(timeline.snapshots() > Timeline::SNAPSHOTS_MAX / 4);
    TEST_ASSERT_TRUE(timeline.last() / static_cast<int64_t>(timeline.snapshots()) <= farthest);
}

TEST(test_snapshots_stay_bounded_and_near)
{
    check_reach(10, Timeline::SPACING_MIN);
    check_reach(60, 4 * Timeline::SPACING_MIN);
}

int64_t ticks_run;

bool count_tick()
{
    ticks_run++;
    return false;
}

// A tick takes 10 µs on a slow machine under a sanitizer: so few of them are not noticed.
TEST(test_a_run_of_10_s_steps_back_at_any_tick_by_one_spacing_of_ticks_at_most)
{
    const nf::Config config = nf::load_scenario("s1_robust", {}, {"scenario.duration_s=10"});
    Timeline timeline(config);
    for (int64_t tick = 999; tick <= timeline.last(); tick += 997) {
        timeline.go_to(tick);
        ticks_run = 0;
        timeline.go_to(tick - 1, count_tick);
        TEST_ASSERT_EQUAL_INT64(tick - 1, timeline.now());
        TEST_ASSERT_TRUE(ticks_run > 0);
        TEST_ASSERT_TRUE(ticks_run <= Timeline::SPACING_MIN);
    }
}

TEST(test_what_is_set_is_repeated_on_the_way_and_ends_when_released)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    timeline.go_to(9000);
    const Mark before(timeline);
    timeline.go_to(12000);
    const Mark untouched(timeline);

    timeline.go_to(9000);
    (void)set_signal(timeline, "load_torque_nm = 4", Span::once);
    timeline.go_to(12000);
    const Mark loaded(timeline);
    TEST_ASSERT_FALSE(loaded == untouched);
    timeline.go_to(8000);
    timeline.go_to(12000);
    TEST_ASSERT_TRUE(Mark(timeline) == loaded);

    TEST_ASSERT_FALSE(timeline.release("load_torque_nm"));
    timeline.go_to(9000);
    TEST_ASSERT_TRUE(timeline.release("load_torque_nm"));
    TEST_ASSERT_TRUE(Mark(timeline) == before);
    timeline.go_to(12000);
    TEST_ASSERT_TRUE(Mark(timeline) == untouched);
}

TEST(test_a_forced_count_is_read_until_it_is_released)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    const auto read = [&] { return timeline.run().sim().in().adc_ia; };
    timeline.go_to(9000);
    (void)set_signal(timeline, "in.adc_ia.raw = 2100", Span::once);
    timeline.step();
    TEST_ASSERT_EQUAL_UINT16(2100, read());
    timeline.step();
    TEST_ASSERT_NOT_EQUAL(2100, read());

    (void)set_signal(timeline, "in.adc_ia.raw = 2101", Span::for_ever);
    timeline.go_to(9005);
    TEST_ASSERT_EQUAL_UINT16(2101, read());
    TEST_ASSERT_TRUE(timeline.release("in.adc_ia"));
    timeline.step();
    TEST_ASSERT_NOT_EQUAL(2101, read());
}

TEST(test_what_is_set_over_what_is_forced_gives_way_to_it_again)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    timeline.go_to(9000);
    (void)set_signal(timeline, "in.adc_ia.raw = 2100", Span::for_ever);
    timeline.go_to(9003);
    (void)set_signal(timeline, "in.adc_ia.raw = 2200", Span::once);
    for (const int count : {2200, 2100, 2100}) {
        timeline.step();
        TEST_ASSERT_EQUAL_INT(count, timeline.run().sim().in().adc_ia);
    }
}

// A scenario's own fault on a channel is there again when what a person has put over it ends, and a
// fault that begins or ends on another channel does not uncover it.
TEST(test_what_is_forced_stands_over_the_scenarios_faults_and_gives_way_to_them)
{
    const nf::Config config = nf::load_scenario(
        "s1_robust", {},
        {R"(scenario.fault=[{time_s=0.3, until_s=0.4, what="adc_a_stuck", value=2}, )"
         R"({time_s=0.301, until_s=0.302, what="adc_bus_stuck", value=310}])"});
    Timeline timeline(config);
    const auto read = [&] { return timeline.run().sim().in().adc_ia; };
    timeline.go_to(timeline.run().tick_at(0.3) + 5);
    const int stuck = read();
    TEST_ASSERT_NOT_EQUAL(2100, stuck);
    (void)set_signal(timeline, "in.adc_ia.raw = 2100", Span::once);
    for (const int count : {2100, stuck, stuck}) {
        timeline.step();
        TEST_ASSERT_EQUAL_INT(count, read());
    }
    (void)set_signal(timeline, "in.adc_ia.raw = 2101", Span::for_ever);
    const int64_t from = timeline.now() + 1;
    for (timeline.step(); timeline.now() < timeline.run().tick_at(0.303); timeline.step()) {
        TEST_ASSERT_EQUAL_INT(2101, read());
    }
    timeline.go_to(from); // a snapshot knows of it
    TEST_ASSERT_EQUAL_INT(2101, read());
    TEST_ASSERT_TRUE(timeline.release("in.adc_ia"));
    timeline.step();
    TEST_ASSERT_EQUAL_INT(stuck, read());
}

// What is said of an assignment that is refused, or "".
static std::string refusal_of(Timeline &timeline, const char *assignment)
{
    try {
        (void)set_signal(timeline, assignment, Span::once);
    } catch (const std::runtime_error &error) {
        return error.what();
    }
    return "";
}

TEST(test_a_command_is_bounded_as_in_a_scenario)
{
    const nf::Config config = nf::load_scenario("s1");
    Timeline timeline(config);
    const char *const cases[][2] = {
        {"speed_command_rpm = 200000", ""},
        {"speed_command_rpm = 1e9",
         "speed_command_rpm is from -200000 to 200000 rpm, found 1000000000"},
        {"speed_command_rpm = abs(0/0)",
         "speed_command_rpm is from -200000 to 200000 rpm, found nan"},
        {"load_torque_nm = -10001", "load_torque_nm is from -10000 to 10000 N m, found -10001"},
    };
    for (const auto &[assignment, refusal] : cases) {
        TEST_ASSERT_EQUAL_STRING(refusal, refusal_of(timeline, assignment).c_str());
    }
}

// The firmware takes its own state for granted: an index, a shift, a choice beyond its range would
// be its end.
TEST(test_a_state_that_the_firmware_cannot_come_to_is_refused)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    timeline.go_to(9000);
    const Mark before(timeline);
    for (const char *assignment :
         {"drive.guard.at.raw = 100000000", "drive.guard.at.raw = 1",
          "drive.voltage_drive.active.raw = 2", "drive.start.align.phase.raw = 77",
          "drive.start.flying_start.phase.raw = 99", "drive.slow_count.raw = 0",
          "drive.motor.model.observer.eta_shift.raw = 40", "load_torque_nm = 1/0"}) {
        const std::string refusal = refusal_of(timeline, assignment);
        const bool refused = !refusal.empty() && refusal.find('\n') == std::string::npos;
        TEST_ASSERT_TRUE_MESSAGE(refused, assignment);
        TEST_ASSERT_TRUE(Mark(timeline) == before);
    }
}

// A run in the field through three configurations: to one that may come while current flows, to one
// with another scale of speeds, with which the drive begins anew, and back. `hashes`: of the drive
// after each tick.
struct Field {
    nf::RecordedRun run;
    std::vector<uint32_t> hashes;
};

static constexpr std::size_t GAIN =
    900; // frames of the changes; more than a spacing of snapshots apart
static constexpr std::size_t SCALE = 2400;
static constexpr std::size_t BACK = 4000;
static constexpr std::size_t FRAMES = 4500;
static constexpr std::size_t BEGIN = 8500; // tick of the simulation, in RUN

static Field changing_run()
{
    const nf::Config config = nf::load_scenario("s1_robust", {"adc"});
    nf::ScriptedRun run(config);
    const auto with = [](const std::vector<std::string> &set) {
        return nf::build(nf::load_scenario("s1_robust", {"adc"}, set));
    };
    while (run.tick() < static_cast<int64_t>(BEGIN)) {
        (void)run.control();
        run.advance();
    }
    Field field{{{run.sim().cfg(), run.sim().drive(), run.sim().bases()},
                 {},
                 {},
                 {{GAIN, with({"observer.kappa=0.03"})},
                  {SCALE, with({"motor.max_speed_rpm=900", "motor.rated_speed_rpm=800",
                                "position_loop.speed_rpm=800",
                                "scenario.command=[{time_s = 0.0, speed_rpm = 500.0}]"})},
                  {BACK, run.sim().cfg()}}},
                {}};
    for (std::size_t frame = 0; frame < FRAMES; frame++) {
        for (const nf::ConfigChange &change : field.run.changes) {
            if (change.frame == frame) {
                run.sim().change(change.cfg);
            }
        }
        (void)run.control();
        field.run.frames.push_back(run.sim().in());
        field.run.outputs.push_back(run.sim().out());
        field.hashes.push_back(drive_words_hash(&run.sim().drive()));
        run.advance();
    }
    return field;
}

static const Field &field()
{
    static const Field made = changing_run();
    return made;
}

static std::size_t frame_of(const Timeline &timeline)
{
    return static_cast<std::size_t>(timeline.now() - timeline.first());
}

static void assert_is_recorded(const Timeline &timeline)
{
    const std::size_t frame = frame_of(timeline);
    const nf::Simulation &sim = timeline.run().sim();
    const std::size_t in_force = (frame >= GAIN ? 1U : 0U) + (frame >= SCALE ? 1U : 0U);
    const bool own = in_force == 0 || frame >= BACK;
    const drive_cfg_t &cfg = own ? field().run.image.cfg : field().run.changes[in_force - 1].cfg;
    TEST_ASSERT_EQUAL_HEX32(field().hashes[frame], drive_words_hash(&sim.drive()));
    TEST_ASSERT_EQUAL_HEX32(cfg.crc, sim.cfg().crc);
    TEST_ASSERT_EQUAL_HEX32(cfg.crc, timeline.run().built().crc);
    TEST_ASSERT_EQUAL_INT(cfg.speed_shift, sim.bases().speed_shift);
}

TEST(test_forth_and_back_over_changes_of_the_configuration_each_tick_is_the_recorded_one)
{
    Timeline timeline(field().run);
    do {
        assert_is_recorded(timeline);
    } while (timeline.step());
    TEST_ASSERT_EQUAL_INT64(timeline.last(), timeline.now());
    for (int64_t tick = timeline.last(); tick >= timeline.first(); tick -= 7) {
        timeline.go_to(tick);
        assert_is_recorded(timeline);
    }
    for (const std::size_t change : {GAIN, SCALE, BACK}) {
        for (const int back : {1, 0}) {
            timeline.go_to(timeline.first() + static_cast<int64_t>(change) - back);
            assert_is_recorded(timeline);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(DRIVE_STATE_RUN, field().run.image.state.state);
    TEST_ASSERT_NOT_EQUAL(field().run.image.cfg.speed_shift,
                          field().run.changes[1].cfg.speed_shift);
}

TEST(test_each_tick_around_a_change_departs_nowhere_from_its_reference)
{
    Timeline timeline(field().run);
    for (const std::size_t change : {GAIN, SCALE, BACK}) {
        timeline.go_to(timeline.first() + static_cast<int64_t>(change) - 20);
        for (int k = 0; k < 40; k++) {
            const auto rows =
                nf::debug::diff_tick(timeline.before(), timeline.tick(), timeline.run().built());
            const nf::debug::Comparison *const first = nf::debug::first_departure(rows);
            TEST_ASSERT_NULL_MESSAGE(
                first, first == nullptr ? "" : (first->module + ' ' + first->quantity).c_str());
            timeline.step();
        }
    }
}

TEST(test_what_is_forced_in_a_configuration_ends_with_it)
{
    Timeline timeline(field().run);
    const int64_t change = timeline.first() + static_cast<int64_t>(GAIN);
    const auto kp = [&] { return timeline.run().sim().cfg().current_loop.pi_d.kp; };
    timeline.go_to(change - 3);
    const std::string said =
        set_signal(timeline, "cfg.current_loop.pi_d.kp.raw = 77", Span::for_ever);
    TEST_ASSERT_EQUAL_STRING(("force cfg.current_loop.pi_d.kp.raw = 77 from tick " +
                              std::to_string(change - 3) + " to " + std::to_string(change - 1) +
                              '\n')
                                 .c_str(),
                             said.c_str());
    timeline.go_to(change - 1);
    TEST_ASSERT_EQUAL_INT(77, kp());
    timeline.step();
    TEST_ASSERT_EQUAL_INT(field().run.changes[0].cfg.current_loop.pi_d.kp, kp());
    timeline.step();
    TEST_ASSERT_EQUAL_INT(field().run.changes[0].cfg.current_loop.pi_d.kp, kp());
}
