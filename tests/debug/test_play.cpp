// SPDX-License-Identifier: MIT
// A run without an end that a person plays with: what is asked for and broken comes again on the
// way back and forth, the recent past alone is kept, and a command in slices is the command.
#include "commands.h"
#include "session.h"
#include "timeline.h"

extern "C" {
#include "drive_words.h"
}

#include <cstring>
#include <map>
#include <string>

#include "testing.h"

using nf::DriveMode;
using nf::FaultEntry;
using nf::FaultKind;
using nf::FaultSpan;
using nf::RequestEntry;
using nf::ScriptedRun;
using nf::debug::Session;
using nf::debug::Timeline;

namespace
{

constexpr int64_t KEPT = 5000;
constexpr int64_t FAR = 30000;

// No script: a person says what happens.
nf::Config machine()
{
    nf::Config config = nf::load_scenario("s1_robust", {"all"});
    config.scenario.prelude_s = 0;
    config.scenario.duration_s = 1000;
    config.scenario.command.clear();
    config.scenario.requests = {{0, false, false}};
    return config;
}

uint32_t hash(const Timeline &timeline)
{
    return drive_words_hash(&timeline.run().sim().drive());
}

drive_state_t state(const Timeline &timeline)
{
    return timeline.run().sim().drive().state;
}

void act(Timeline &timeline, const Timeline::Act &what)
{
    timeline.edit("person", "an act", timeline.now(), what);
}

FaultEntry lasting(FaultKind kind)
{
    return {0, kind, FaultSpan::lasting, {}, {}};
}

void ask(Timeline &timeline, const RequestEntry &entry)
{
    act(timeline, [entry](ScriptedRun &run) { run.ask(entry); });
}

void run_at(Timeline &timeline, double rpm)
{
    ask(timeline, {0, true, false});
    act(timeline, [rpm](ScriptedRun &run) { run.set_command(DriveMode::speed, rpm); });
}

bool steps_to(Timeline &timeline, drive_state_t wanted, int64_t at_most)
{
    while (state(timeline) != wanted && at_most-- > 0 && timeline.step()) {
    }
    return state(timeline) == wanted;
}

TEST(test_nothing_runs_until_a_person_asks)
{
    const nf::Config config = machine();
    Timeline timeline(config);
    timeline.go_to(FAR);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, state(timeline));
    run_at(timeline, 500);
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_RUN, FAR));
    ask(timeline, {0, false, false});
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_READY, 10));
}

// Broken, cleared in vain, repaired, cleared, run again, then a position.
TEST(test_acts_come_again_on_the_way)
{
    const nf::Config config = machine();
    Timeline timeline(config);
    timeline.go_to(6000);
    run_at(timeline, 1000);
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_RUN, FAR));
    act(timeline, [](ScriptedRun &run) { run.begin_fault(lasting(FaultKind::phase_a_open)); });
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_FAULT, FAR));
    const int64_t fault = timeline.now();
    act(timeline, [](ScriptedRun &run) { run.end_fault(FaultKind::phase_a_open); });
    ask(timeline, {0, {}, true});
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_READY, FAR));
    ask(timeline, {0, true, false});
    act(timeline, [](ScriptedRun &run) { run.set_command(DriveMode::position, 3.0); });
    TEST_ASSERT_TRUE(steps_to(timeline, DRIVE_STATE_RUN, FAR));
    timeline.go_to(timeline.now() + 2000);
    TEST_ASSERT_EQUAL(DRIVE_MODE_POSITION, timeline.run().sim().drive().motion.mode);

    const int64_t end = timeline.now();
    const uint32_t at_end = hash(timeline);
    timeline.go_to(fault - 1);
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, state(timeline));
    TEST_ASSERT_EQUAL(DRIVE_MODE_SPEED, timeline.run().sim().drive().motion.mode);
    timeline.step();
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, state(timeline));
    timeline.go_to(end);
    TEST_ASSERT_EQUAL_HEX32(at_end, hash(timeline));
}

TEST(test_the_recent_past_alone_is_kept)
{
    const nf::Config config = machine();
    Timeline timeline(config, KEPT);
    ask(timeline, {0, true, false});
    std::map<int64_t, uint32_t> hashes;
    while (timeline.now() < FAR) {
        timeline.step();
        hashes[timeline.now()] = hash(timeline);
    }
    TEST_ASSERT_TRUE(timeline.first() <= FAR - KEPT);
    TEST_ASSERT_TRUE(timeline.first() > FAR - KEPT - 2 * Timeline::SPACING_MIN);
    TEST_ASSERT_TRUE(timeline.snapshots() <= KEPT / Timeline::SPACING_MIN + 2);
    TEST_ASSERT_TRUE(timeline.edits().empty()); // its effect lies in the oldest snapshot
    for (const int64_t tick : {timeline.first(), FAR - KEPT, FAR - 1, FAR}) {
        timeline.go_to(tick);
        TEST_ASSERT_EQUAL_HEX32(hashes[tick], hash(timeline));
    }
}

int64_t left = 0;

bool is_slice_over()
{
    left--;
    return left < 0;
}

// As a page does it that lets other things happen in between.
void in_slices(Session &session, const std::string &line)
{
    constexpr int64_t SLICE = 2 * Timeline::SPACING_MIN;
    session.stop = is_slice_over;
    std::string rest = line;
    int slices = 0;
    do {
        left = SLICE;
        (void)nf::debug::execute(session, rest);
        rest = session.wanted ? "goto " + std::to_string(*session.wanted) : line;
        slices++;
    } while (left < 0);
    TEST_ASSERT_TRUE(slices > 1);
}

TEST(test_a_command_in_slices_is_the_command)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    for (const char *const line : {"run until speed_rpm > 900", "step 9000", "goto 0.5s"}) {
        Session whole(config);
        Session sliced(config);
        (void)nf::debug::execute(whole, line);
        in_slices(sliced, line);
        TEST_ASSERT_EQUAL_INT64_MESSAGE(whole.timeline.now(), sliced.timeline.now(), line);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(hash(whole.timeline), hash(sliced.timeline), line);
    }
}

} // namespace
