// SPDX-License-Identifier: MIT
// A follower of a simulated board: what it shows is bit for bit what the board has computed,
// whatever the line does to it.
#include "board_commands.h"
#include "cfg_rows.h"
#include "late_channel.h"
#include "lossy_channel.h"
#include "output_file.h"
#include "own_path.h"
#include "reader.h"
#include "replay.h"
#include "trace.h"
#include "watched_board.h"

extern "C" {
#include "config_ceiling.h"
#include "config_check.h"
#include "config_guard.h"
#include "config_lock.h"
#include "testing.h"
}

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include <unistd.h>

#include <fmt/format.h>

namespace
{

using nf::live::BoardChannel;
using nf::live::BoardCommands;
using nf::live::Follower;
using nf::live::FollowerOptions;
using nf::live::LossyChannel;
using nf::live::SimulatedBoard;

constexpr double PASS_S = 0.001;
constexpr double RUN_S = 60;
constexpr double RESYNC_S =
    1; // at most, from the last tick before a gap to the first one behind it
constexpr double TICKS_PER_S = 10000;

// At 500 kBd an answer takes some 5 ms at most: a question, an answer, and a frame of the stream
// that is on its way.
constexpr FollowerOptions QUICK = {{0.02, 100, 0.006}, 10, 0.2, 1};

std::vector<std::string> settings(const std::vector<std::string> &more,
                                  const std::vector<std::string> &scenario)
{
    std::vector<std::string> all = {"board.baud=500000", "board.recorder_entries=1280"};
    all.insert(all.end(), scenario.begin(), scenario.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

// A board, its line, and who follows it.
struct Bench {
    explicit Bench(const nf::Config &config_, const nf::live::Loss &loss = {})
        : config(config_), board(config), clean(board, &log), line(clean, loss, loss, 1),
          shown(log), follower(line, shown,
                               {[this](const std::string &text) { said.push_back(text); },
                                [this](const std::string &text) { commands.take_text(text); }},
                               QUICK),
          commands(follower, {},
                   {[this](const std::string &text) { said.push_back(text); },
                    [this](double seconds) { pass(seconds); },
                    [](const nf::RecordedRun &) { return true; }})
    {
    }

    void pass(double seconds)
    {
        const double until_s = line.now_s() + seconds;
        while (line.now_s() < until_s) {
            follower.step(PASS_S);
        }
    }

    void do_line(const std::string &text)
    {
        const nf::debug::Answer answer = commands.execute(text);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::done, answer.outcome,
                                  (text + ": " + answer.text).c_str());
    }

    std::string refusal_of(const std::string &text)
    {
        const nf::debug::Answer answer = commands.execute(text);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::refused, answer.outcome, text.c_str());
        return answer.text;
    }

    std::string all_said() const
    {
        return fmt::format("{}", fmt::join(said, "\n"));
    }

    const nf::Config config;
    BoardLog log;
    SimulatedBoard board;
    BoardChannel clean;
    LossyChannel line;
    ShownTicks shown;
    std::vector<std::string> said;
    Follower follower;
    BoardCommands commands;
};

// Start, speeds, load steps and a fault, by the script of the scenario: the line has no part in it.
nf::Config scripted(const std::string &duration_s, const std::vector<std::string> &more = {})
{
    return nf::load_scenario(
        "s2_robust", {"adc"},
        settings(more, {"scenario.duration_s=" + duration_s,
                        "scenario.load=[{time_s = 5, torque_nm = 3}, {time_s = 8, torque_nm = 0}, "
                        "{time_s = 40, torque_nm = 2}, {time_s = 45, torque_nm = 0}]",
                        "scenario.fault=[{time_s = 50, what = \"adc_a_high\", until_s = 50.1}]"}));
}

std::string file_text(const std::string &path)
{
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

// The trace of a run of the board's inputs on this program's drive, from the first tick that was
// shown.
void write_native_trace(const Bench &bench, const nf::DriveImage &power_up, const std::string &path)
{
    nf::ScriptedRun run(nf::RecordedRun{power_up, bench.log.frames, bench.log.outputs, {}});
    nf::Trace trace(path, false);
    while (run.tick() <= static_cast<int64_t>(bench.shown.ticks.back())) {
        const nf::Tick tick = run.control();
        if (run.tick() >= static_cast<int64_t>(bench.shown.ticks.front())) {
            trace.add(tick);
        }
        run.advance();
    }
    trace.close();
}

// Both: the ticks are looked at, and written.
class Both : public nf::TickSink
{
public:
    Both(nf::TickSink &one, nf::TickSink &other) : one_(one), other_(other)
    {
    }
    void add(const nf::Tick &tick) override
    {
        one_.add(tick);
        other_.add(tick);
    }

private:
    nf::TickSink &one_;
    nf::TickSink &other_;
};

TEST(a_minute_of_start_run_load_position_and_fault_is_shown_bit_for_bit)
{
    Bench bench(scripted("60"));
    const nf::DriveImage power_up = {bench.board.run().sim().cfg(), bench.board.run().sim().drive(),
                                     bench.board.run().sim().bases()};
    const std::string shown_path = own_path("nf_live_shown.csv");
    const std::string native_path = own_path("nf_live_native.csv");
    nf::Trace trace(shown_path, false);
    Both both(bench.shown, trace);
    Follower follower(
        bench.line, both,
        {[&](const std::string &text) { bench.said.push_back(text); }, [](const std::string &) {}},
        QUICK);
    BoardCommands commands(follower, {},
                           {[](const std::string &) {},
                            [&](double seconds) {
                                const double until_s = bench.line.now_s() + seconds;
                                while (bench.line.now_s() < until_s) {
                                    follower.step(PASS_S);
                                }
                            },
                            [](const nf::RecordedRun &) { return true; }});
    follower.connect();
    for (const char *line :
         {"wait 1",     "run",     "speed 1000",       "wait 14", "speed -1500", "wait 5",
          "position 3", "wait 5",  "position -720deg", "wait 5",  "speed 1800",  "wait 20",
          "torque 1",   "wait 1",  "speed 1800",       "wait 5",  "clear",       "wait 1",
          "run",        "wait 3.5"}) {
        const nf::debug::Answer answer = commands.execute(line);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::done, answer.outcome,
                                  (std::string(line) + ": " + answer.text).c_str());
    }
    trace.close();
    TEST_ASSERT_EQUAL_MESSAGE(0, follower.gaps().size(), bench.all_said().c_str());
    TEST_ASSERT_EQUAL(0, follower.departures());
    TEST_ASSERT_EQUAL(0, bench.shown.wrong);
    TEST_ASSERT_EQUAL(0, bench.shown.jumps);
    // From the first announced segment to the last whole one.
    constexpr std::size_t NOT_SHOWN = 2 * 1280 / 4;
    TEST_ASSERT_GREATER_OR_EQUAL(bench.log.hashes.size() - NOT_SHOWN, bench.shown.ticks.size());
    TEST_ASSERT_GREATER_THAN(RUN_S * TICKS_PER_S - NOT_SHOWN, bench.shown.ticks.size());
    const std::set<drive_state_t> states(bench.log.states.begin(), bench.log.states.end());
    for (const drive_state_t state : {DRIVE_STATE_READY, DRIVE_STATE_RUN, DRIVE_STATE_FAULT}) {
        TEST_ASSERT_EQUAL(1, states.count(state));
    }
    write_native_trace(bench, power_up, native_path);
    TEST_ASSERT_TRUE(file_text(shown_path) == file_text(native_path));
    std::filesystem::remove(shown_path);
    std::filesystem::remove(native_path);
    fmt::print("shown {} of {} ticks, {} hashes equal, {} bytes from the board, {} asked again\n",
               bench.shown.ticks.size(), bench.log.hashes.size(),
               follower.shadow().hashes_compared(), follower.bytes_in(),
               follower.client().repeats());
}

TEST(no_tick_is_lost_where_the_numbers_of_the_segments_begin_again)
{
    constexpr double FOLLOWED_S = 3; // some 90 segments
    for (const uint32_t before : {UINT32_MAX - 40, UINT32_MAX - 1, UINT32_MAX}) {
        Bench bench(scripted("60"));
        bench.board.link().live->app->recorder->ended = before;
        bench.follower.connect();
        bench.pass(FOLLOWED_S);
        TEST_ASSERT_EQUAL_MESSAGE(0, bench.follower.gaps().size(), bench.all_said().c_str());
        TEST_ASSERT_EQUAL(0, bench.follower.departures());
        TEST_ASSERT_EQUAL(0, bench.shown.wrong);
        TEST_ASSERT_EQUAL(0, bench.shown.jumps);
        constexpr std::size_t NOT_SHOWN = 2 * 1280 / 4;
        TEST_ASSERT_GREATER_OR_EQUAL(bench.log.hashes.size() - NOT_SHOWN, bench.shown.ticks.size());
    }
}

// No tick is shown that is not in a gap that was named, and the other way round.
void assert_gaps_are_those_named(const Bench &bench)
{
    const std::vector<nf::live::Gap> &gaps = bench.follower.gaps();
    std::size_t named = 0;
    for (std::size_t k = 1; k < bench.shown.ticks.size(); k++) {
        const std::size_t before = bench.shown.ticks[k - 1];
        const std::size_t tick = bench.shown.ticks[k];
        if (tick != before + 1) {
            const auto is_it = [&](const nf::live::Gap &gap) {
                return gap.from <= static_cast<int64_t>(before + 1) &&
                       gap.until >= static_cast<int64_t>(tick);
            };
            TEST_ASSERT_TRUE(std::any_of(gaps.begin(), gaps.end(), is_it));
            named++;
            TEST_ASSERT_LESS_THAN(RESYNC_S * TICKS_PER_S, tick - before);
        }
    }
    fmt::print("{} gaps, {} ticks of {} shown, {} bytes spoilt, {} frames broken\n", named,
               bench.shown.ticks.size(), bench.log.hashes.size(), bench.line.spoilt_bytes(),
               bench.follower.broken());
}

TEST(a_line_that_spoils_one_byte_in_a_hundred_shows_nothing_wrong)
{
    constexpr double THIRD = 0.01 / 3;
    constexpr double FOLLOWED_S = 20;
    constexpr int RING = 1168; // that of the shipped boards with an STM32G431
    // Of ten seeds: no gap to 11 of them, 83 to 98 % of the ticks shown.
    constexpr double SHOWN_MIN = 2.0 / 3;
    const nf::Config config =
        scripted("60", {fmt::format("board.recorder_entries={}", RING), "board.baud=760000"});
    Bench bench(config, {THIRD, THIRD, THIRD});
    bench.follower.connect();
    bench.pass(FOLLOWED_S);
    TEST_ASSERT_EQUAL_MESSAGE(0, bench.follower.departures(), bench.all_said().c_str());
    TEST_ASSERT_EQUAL(0, bench.shown.wrong);
    assert_gaps_are_those_named(bench);
    TEST_ASSERT_GREATER_THAN(SHOWN_MIN * FOLLOWED_S * TICKS_PER_S, bench.shown.ticks.size());
    TEST_ASSERT_GREATER_THAN((FOLLOWED_S - RESYNC_S) * TICKS_PER_S, bench.shown.ticks.back());
    // The motor does what it does without anybody on the line.
    SimulatedBoard alone(config);
    BoardLog log;
    for (std::size_t k = 0; k < bench.log.hashes.size(); k++) {
        log.add(alone.tick());
    }
    TEST_ASSERT_TRUE(log.hashes == bench.log.hashes);
}

// A line that is cut for a while.
class CutChannel : public nf::live::Channel
{
public:
    explicit CutChannel(nf::live::Channel &channel) : channel_(channel)
    {
    }
    std::vector<uint8_t> read(double wait_s) override
    {
        const std::vector<uint8_t> bytes = channel_.read(wait_s);
        return cut ? std::vector<uint8_t>{} : bytes;
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        if (!cut) {
            channel_.write(bytes);
        }
    }
    double now_s() const override
    {
        return channel_.now_s();
    }

    bool cut = false;

private:
    nf::live::Channel &channel_;
};

TEST(after_a_cut_the_gap_is_named_and_it_is_in_step_within_a_second)
{
    constexpr double CUT_S = 0.5; // longer than the ring
    const nf::Config config = scripted("60");
    BoardLog log;
    SimulatedBoard board(config);
    BoardChannel clean(board, &log);
    CutChannel line(clean);
    ShownTicks shown(log);
    std::vector<std::string> said;
    Follower follower(
        line, shown,
        {[&](const std::string &text) { said.push_back(text); }, [](const std::string &) {}},
        QUICK);
    const auto pass = [&](double seconds) {
        const double until_s = line.now_s() + seconds;
        while (line.now_s() < until_s) {
            follower.step(PASS_S);
        }
    };
    follower.connect();
    pass(1);
    line.cut = true;
    pass(CUT_S);
    line.cut = false;
    const auto back = static_cast<int64_t>(log.hashes.size());
    pass(RESYNC_S);
    TEST_ASSERT_EQUAL(0, shown.wrong);
    TEST_ASSERT_EQUAL(1, follower.gaps().size());
    const nf::live::Gap gap = follower.gaps().front();
    TEST_ASSERT_GREATER_THAN(0, gap.until);
    TEST_ASSERT_LESS_THAN(back + static_cast<int64_t>(RESYNC_S * TICKS_PER_S), gap.until);
    TEST_ASSERT_EQUAL(1, shown.jumps);
    TEST_ASSERT_EQUAL(2, said.size());
    TEST_ASSERT_EQUAL_STRING(nf::live::gap_text(gap).c_str(), said.back().c_str());
    fmt::print("{}; the line was back at {}\n", said.back(), back);
}

bool is_locked(const drive_cfg_t &from, const drive_cfg_t &to)
{
    config_lock_t lock{};
    config_lock_keep(&lock, &from);
    return config_lock_refused(&lock, &from, &to) != nullptr;
}

// The block in force, which is the image's, with another value of a row; nothing where the image
// takes neither neighbour of its value. Of what is locked the one that protects less.
std::optional<config_block_t> neighbour(const config_block_t &block, const nf::CfgRow &row)
{
    // A time-out of a tick would stop the drive, and rightly.
    const int64_t size = std::string(row.path) == "link.timeout_ticks" ? 100000 : 1;
    for (const int64_t step : {size, -size}) {
        drive_cfg_t cfg = block.cfg;
        const auto raw = static_cast<uint32_t>(nf::raw_value(row, cfg) + step);
        std::memcpy(reinterpret_cast<unsigned char *>(&cfg) + row.offset, &raw, sizeof raw);
        cfg.crc = config_guard_crc(&cfg);
        if (config_check(&cfg) == nullptr &&
            config_ceiling_crossed(&block.cfg, &cfg, true) == nullptr &&
            !is_locked(cfg, block.cfg)) {
            config_block_t changed{};
            config_block_make(&changed, &block.identity, &block.about, &cfg);
            return changed;
        }
    }
    return std::nullopt;
}

TEST(the_configuration_in_force_may_be_given_again)
{
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(2);
    TEST_ASSERT_EQUAL_STRING("", bench.follower.change(bench.follower.block_in_force()).c_str());
    bench.pass(0.5);
    TEST_ASSERT_EQUAL_MESSAGE(0, bench.follower.gaps().size(), bench.all_said().c_str());
    TEST_ASSERT_EQUAL(0, bench.shown.wrong);
}

TEST(each_setting_that_may_change_in_run_does_under_load_and_the_others_are_refused_by_name)
{
    constexpr double BETWEEN_S = 0.01; // several changes may be in a segment
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(7); // 3 N·m from 5 s on
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, bench.log.states.back());
    int changed = 0;
    int refused = 0;
    int fixed = 0;
    const config_block_t now = bench.follower.block_in_force();
    for (const nf::CfgRow &row : nf::cfg_rows()) {
        const std::optional<config_block_t> wanted = neighbour(now, row);
        if (!wanted) {
            fixed++;
            continue;
        }
        const std::string why = bench.follower.change(*wanted);
        if (row.in_run && !is_locked(now.cfg, wanted->cfg)) {
            TEST_ASSERT_EQUAL_STRING_MESSAGE("", why.c_str(), row.path);
            bench.pass(BETWEEN_S);
            TEST_ASSERT_EQUAL_STRING("", bench.follower.change(now).c_str());
            changed++;
        } else {
            TEST_ASSERT_TRUE_MESSAGE(why.find(std::string(row.path) + " ") == 0,
                                     (row.path + (": " + why)).c_str());
            refused++;
        }
        bench.pass(BETWEEN_S);
        const fault_t &fault = bench.board.run().sim().drive().fault;
        TEST_ASSERT_EQUAL_MESSAGE(DRIVE_STATE_RUN, bench.log.states.back(),
                                  fmt::format("{}: {} {} {}", row.path, static_cast<int>(fault.id),
                                              fault.value, fault.limit)
                                      .c_str());
    }
    bench.pass(1);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, bench.log.states.back());
    TEST_ASSERT_EQUAL_MESSAGE(0, bench.follower.gaps().size(), bench.all_said().c_str());
    TEST_ASSERT_EQUAL(0, bench.follower.departures());
    TEST_ASSERT_EQUAL(0, bench.shown.wrong);
    TEST_ASSERT_EQUAL(0, bench.shown.jumps);
    TEST_ASSERT_EQUAL(nf::cfg_rows().size(), changed + refused + fixed);
    TEST_ASSERT_GREATER_THAN(0, changed);
    TEST_ASSERT_GREATER_THAN(0, refused);
    const std::optional<nf::RecordedRun> run = bench.follower.shadow().run(BETWEEN_S * changed);
    TEST_ASSERT_TRUE(run.has_value() && !run->changes.empty());
    fmt::print("{} settings changed in RUN, {} refused by name, {} have no neighbour\n", changed,
               refused, fixed);
}

// What a slow line shows of a running motor within 10 s.
struct SlowLine {
    SlowLine(int entries, int baud)
        : board(nf::load_scenario("s2_robust", {"adc"},
                                  {"scenario.duration_s=60", fmt::format("board.baud={}", baud),
                                   fmt::format("board.recorder_entries={}", entries)})),
          line(board, &log), shown(log),
          follower(line, shown,
                   {[this](const std::string &text) { said.push_back(text); },
                    [](const std::string &) {}},
                   {})
    {
        constexpr double FOLLOWED_S = 10;
        follower.connect();
        while (line.now_s() < FOLLOWED_S) {
            follower.step(PASS_S);
        }
    }

    std::size_t longest_gap() const
    {
        std::size_t longest = 0;
        for (std::size_t k = 1; k < shown.ticks.size(); k++) {
            longest = std::max(longest, shown.ticks[k] - shown.ticks[k - 1]);
        }
        return longest;
    }

    BoardLog log;
    SimulatedBoard board;
    BoardChannel line;
    ShownTicks shown;
    std::vector<std::string> said;
    Follower follower;
};

// 115200 baud carry half of the ticks. The board keeps the state that is read; behind it a segment
// of 304 entries, 660 bytes, has to come within 0.1 s, which such a line carries too.
// 16 ms is what a common USB adapter collects bytes for.
TEST(a_line_whose_bytes_come_late_is_followed_without_a_gap)
{
    constexpr double IN_STEP_S =
        3; // the words of a state are 11 questions, each of twice 0.1 s at most
    constexpr double FOLLOWED_S = 2;
    for (const double late_s : {0.016, 0.05, 0.1}) {
        SimulatedBoard board(scripted("60"));
        BoardLog log;
        BoardChannel clean(board, &log);
        LateChannel late(clean, late_s);
        ShownTicks shown(log);
        Follower follower(late, shown, {}, {{}, 10, 0.2, 1});
        follower.connect();
        const double from_s = late.now_s();
        while (!follower.shadow().is_in_step() && late.now_s() < from_s + IN_STEP_S) {
            follower.step(PASS_S);
        }
        TEST_ASSERT_TRUE_MESSAGE(follower.shadow().is_in_step(), fmt::format("{}", late_s).c_str());
        const double until_s = late.now_s() + FOLLOWED_S;
        while (late.now_s() < until_s) {
            follower.step(PASS_S);
        }
        TEST_ASSERT_EQUAL_MESSAGE(0, follower.gaps().size(), fmt::format("{}", late_s).c_str());
        TEST_ASSERT_EQUAL(0, shown.wrong);
        TEST_ASSERT_GREATER_THAN((FOLLOWED_S - 1) * TICKS_PER_S, shown.ticks.size());
    }
}

TEST(at_115200_baud_some_of_each_second_is_shown_with_any_ring)
{
    for (const int entries : {1168, 4096}) {
        constexpr std::size_t SOME = 20; // one tick in so many
        const SlowLine slow(entries, 115200);
        TEST_ASSERT_EQUAL(0, slow.shown.wrong);
        TEST_ASSERT_GREATER_THAN(slow.log.hashes.size() / SOME, slow.shown.ticks.size());
        TEST_ASSERT_LESS_THAN(RESYNC_S * TICKS_PER_S, slow.longest_gap());
        fmt::print("{} entries, 115200 baud: {} ticks of {} shown, {} gaps\n", entries,
                   slow.shown.ticks.size(), slow.log.hashes.size(), slow.follower.gaps().size());
    }
}

TEST(a_line_that_carries_no_segment_in_time_is_told)
{
    const SlowLine slow(1168, 19200);
    TEST_ASSERT_EQUAL(0, slow.shown.wrong);
    TEST_ASSERT_TRUE(std::any_of(slow.said.begin(), slow.said.end(), [](const std::string &text) {
        return text.find("not in step: the ring of the board is overwritten") == 0;
    }));
}

const drive_command_t &told(const Bench &bench)
{
    return bench.log.frames.back().command;
}

// Nobody is on the line.
void leave_alone(Bench &bench, double seconds)
{
    const double until_s = bench.line.now_s() + seconds;
    while (bench.line.now_s() < until_s) {
        (void)bench.line.read(PASS_S);
    }
}

constexpr double SETTLES_S = 2; // from power-up to a motor that the script has in RUN

// The load takes what is commanded, so the speed stays. The model's torque and the motor's differ
// by the parameters' errors of this plant, the mean by its noise.
TEST(a_torque_is_commanded_in_newton_metres)
{
    constexpr double TORQUE_NM = 1;
    constexpr double TORQUE_SHARE = 0.03;
    constexpr double SLOPE_S = 0.15; // to reach it
    constexpr int PASSES = 50;
    Bench bench(
        scripted("60", {fmt::format("scenario.load=[{{time_s = 1, torque_nm = {}}}]", TORQUE_NM)}));
    leave_alone(bench, SETTLES_S);
    bench.follower.connect();
    bench.pass(RESYNC_S);
    bench.do_line(fmt::format("torque {}", TORQUE_NM));
    bench.pass(SLOPE_S);
    double mean_nm = 0;
    for (int k = 0; k < PASSES; k++) {
        bench.pass(PASS_S);
        plant_view_t truth{};
        plant_view(&bench.board.run().sim().plant(), &truth);
        mean_nm += truth.torque_nm / PASSES;
    }
    TEST_ASSERT_DOUBLE_WITHIN(TORQUE_SHARE * TORQUE_NM, TORQUE_NM, mean_nm);
}

double shaft_turns(const Bench &bench)
{
    plant_view_t truth{};
    plant_view(&bench.board.run().sim().plant(), &truth);
    return truth.theta_mech_rad / (2 * 3.14159265358979);
}

// At rest the drive does not know where the rotor is, and the board's console says so.
TEST(a_zero_moves_nothing_and_positions_count_from_it)
{
    constexpr double TURNS = 0.01;
    Bench bench(scripted("60", {"scenario.load=[{time_s = 59, torque_nm = 0}]"}));
    leave_alone(bench, SETTLES_S);
    bench.follower.connect();
    bench.pass(RESYNC_S);
    bench.do_line("position 0.75"); // of the turn that it is in
    bench.pass(SETTLES_S);
    const double there = shaft_turns(bench);
    TEST_ASSERT_DOUBLE_WITHIN(TURNS, 0.75, there - std::floor(there));
    bench.do_line("zero");
    bench.pass(SETTLES_S);
    TEST_ASSERT_EQUAL(DRIVE_REQUEST_RUN, told(bench).request);
    TEST_ASSERT_EQUAL_INT32(0, told(bench).target);
    TEST_ASSERT_DOUBLE_WITHIN(TURNS, there, shaft_turns(bench));
    bench.do_line("position -1.5");
    bench.pass(SETTLES_S);
    TEST_ASSERT_DOUBLE_WITHIN(TURNS, there - 1.5, shaft_turns(bench));
    bench.do_line("stop");
    bench.do_line("zero");
    bench.pass(RESYNC_S);
    TEST_ASSERT_EQUAL(0, told(bench).request);
}

TEST(a_speed_before_the_command_in_force_is_known_is_refused_and_the_motor_runs_on)
{
    Bench bench(scripted("60"));
    leave_alone(bench, SETTLES_S);
    bench.follower.connect();
    for (const char *line : {"speed 1000", "position 1", "run"}) {
        TEST_ASSERT_EQUAL(0, bench.refusal_of(line).find("not in step yet: "));
    }
    bench.pass(RESYNC_S);
    TEST_ASSERT_EQUAL(DRIVE_REQUEST_RUN, told(bench).request);
    bench.do_line("speed 1000");
    bench.pass(0.1);
    TEST_ASSERT_EQUAL(DRIVE_REQUEST_RUN, told(bench).request);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, bench.log.states.back());
}

TEST(a_stop_before_the_command_in_force_is_known_stops)
{
    Bench bench(scripted("60"));
    leave_alone(bench, SETTLES_S);
    bench.follower.connect();
    bench.do_line("stop");
    TEST_ASSERT_EQUAL(0, bench.refusal_of("speed 1000").find("not in step yet: "));
    bench.pass(RESYNC_S);
    TEST_ASSERT_EQUAL(0, told(bench).request);
}

// The last number of each limit that a refusal names, and what is just beyond it.
TEST(what_a_refusal_names_as_the_range_is_taken_at_both_ends)
{
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(1);
    const std::string turns = bench.refusal_of("position 1e9");
    TEST_ASSERT_EQUAL_STRING("position takes turns, or degrees as 90deg, -16383 to 16383 "
                             "turns, found \"1e9\"",
                             turns.c_str());
    const std::string degrees = bench.refusal_of("position 1e9deg");
    TEST_ASSERT_TRUE(degrees.find("-5897880 to 5897880 degrees") != std::string::npos);
    for (const char *const inside : {"position -16383", "position 16383", "position -5897880deg",
                                     "position 5897880deg", "speed 0"}) {
        bench.do_line(inside);
    }
    for (const char *const outside : {"position 16383.0001", "position -16383.0001",
                                      "position 5897880.1deg", "position -5897880.1deg"}) {
        (void)bench.refusal_of(outside);
    }
    for (const char *const command : {"speed ", "torque "}) {
        const std::string range = bench.refusal_of(std::string(command) + "1e9");
        const std::size_t begin = range.find("takes ");
        const std::size_t first = range.find_first_of("-0123456789", begin);
        const std::string lowest = range.substr(first, range.find(' ', first) - first);
        const std::size_t second = range.find(" to ", first) + 4;
        const std::string highest = range.substr(second, range.find(',', second) - second);
        bench.do_line(command + lowest);
        bench.do_line(command + highest);
    }
}

TEST(a_speed_does_not_start_a_motor_that_the_board_has_stopped)
{
    constexpr double TIMEOUT_S = 0.4;
    constexpr double SILENCE_S = 20; // a ramp to rest is in it
    Bench bench(scripted("60", {fmt::format("tuning.command_timeout_s={}", TIMEOUT_S)}));
    bench.follower.connect();
    bench.pass(RESYNC_S);
    bench.do_line("run");
    bench.do_line("speed 1000");
    bench.pass(SETTLES_S);
    TEST_ASSERT_EQUAL(DRIVE_REQUEST_RUN, told(bench).request);
    leave_alone(bench, SILENCE_S);
    TEST_ASSERT_EQUAL(0, told(bench).request);
    bench.pass(QUICK.silent_s + 2 * RESYNC_S); // it is asked who it is, first
    bench.do_line("speed 500");
    bench.pass(0.1);
    TEST_ASSERT_EQUAL(0, told(bench).request);
}

TEST(a_speed_does_not_end_a_measurement_and_a_stop_does)
{
    nf::Config own = scripted("60", {"scenario.load=[]"});
    own.sources.motor_is_example = false;
    Bench bench(own);
    bench.follower.connect();
    bench.pass(0.2);
    bench.do_line("stop"); // before it turns
    bench.pass(RESYNC_S);
    bench.follower.client().line("identify"); // the command of the follower waits for the end
    bench.pass(RESYNC_S); // what another has asked for shows when its ticks are shown
    for (int k = 0; k < 20; k++) {
        TEST_ASSERT_EQUAL_STRING("the motor is being measured; stop ends that",
                                 bench.refusal_of("speed 500").c_str());
        bench.pass(0.1);
    }
    TEST_ASSERT_EQUAL_MESSAGE(DRIVE_REQUEST_PROBE, told(bench).request, bench.all_said().c_str());
    bench.do_line("stop");
    bench.pass(0.1);
    TEST_ASSERT_EQUAL(0, told(bench).request);
}

TEST(a_fault_whose_recording_is_kept_is_said_with_its_advice)
{
    constexpr double BEHIND_THE_FAULT_S =
        55; // the fault is at 50 s of the script, which begins behind power-up
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(RESYNC_S);
    bench.do_line("run");
    bench.follower.leave();
    leave_alone(bench, BEHIND_THE_FAULT_S);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, bench.log.states.back());
    bench.follower.connect();
    bench.pass(RESYNC_S);
    TEST_ASSERT_TRUE(
        bench.all_said().find("no stream: the recording of a fault is kept until it is read") !=
        std::string::npos);
    TEST_ASSERT_TRUE_MESSAGE(bench.all_said().find("board: FAULT") != std::string::npos,
                             bench.all_said().c_str());
}

nf::replay::Recording recorded(Bench &bench)
{
    const std::string path = own_path("nf_live_recorded.log");
    bench.do_line("record " + path);
    const nf::replay::Recording recording = nf::replay::read_file(path);
    std::filesystem::remove(path);
    return recording;
}

TEST(a_fault_that_was_shown_is_in_the_recording_also_when_the_motor_runs_again)
{
    constexpr double FAULT_S = 3; // behind power-up at the latest
    constexpr double SETS_S = 0.3;
    Bench bench(
        scripted("60", {"scenario.fault=[{time_s = 2, what = \"adc_a_high\", until_s = 2.1}]"}));
    bench.follower.connect();
    bench.pass(0.5);
    for (const char *line : {"run", "speed 900"}) {
        bench.do_line(line);
    }
    for (const char *line :
         {"set observer.kappa=0.024", "set observer.kappa=0.025", "set observer.kappa=0.026"}) {
        bench.do_line(line);
        bench.pass(SETS_S);
    }
    bench.pass(FAULT_S);
    TEST_ASSERT_EQUAL_MESSAGE(DRIVE_STATE_FAULT, bench.log.states.back(), bench.all_said().c_str());
    bench.do_line("clear");
    bench.pass(0.2);
    bench.do_line("run");
    bench.pass(SETTLES_S);
    const auto fault_tick = static_cast<int64_t>(
        std::find(bench.log.states.begin(), bench.log.states.end(), DRIVE_STATE_FAULT) -
        bench.log.states.begin());
    const nf::replay::Recording recording = recorded(bench);
    const nf::replay::Result result = nf::replay::replay(recording);
    TEST_ASSERT_FALSE_MESSAGE(result.difference.has_value(),
                              nf::replay::summary(recording, result).c_str());
    TEST_ASSERT_EQUAL(FAULT_ADC_SATURATED, recording.fault().id);
    TEST_ASSERT_EQUAL(fault_tick, recording.fault().tick);
    TEST_ASSERT_EQUAL(fault_tick + 64, recording.last());
    TEST_ASSERT_EQUAL(1,
                      recording.run.changes.size()); // of four configurations it holds the last two
    TEST_ASSERT_LESS_THAN(fault_tick - static_cast<int64_t>(SETS_S * TICKS_PER_S),
                          recording.run.first());
}

TEST(what_was_shown_can_be_recorded_when_the_board_has_gone)
{
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(RESYNC_S);
    const auto shown = static_cast<int64_t>(bench.shown.ticks.back());
    leave_alone(bench, 2 * RESYNC_S); // the ring has forgotten what follows
    while (bench.follower.shadow().is_in_step()) {
        bench.follower.step(PASS_S);
    }
    const nf::replay::Recording recording = recorded(bench);
    TEST_ASSERT_FALSE(nf::replay::replay(recording).difference.has_value());
    TEST_ASSERT_EQUAL(shown, recording.last());
}

TEST(a_fault_that_came_while_nobody_was_heard_is_recorded_from_the_board)
{
    constexpr double SILENCE_S = 3; // the line goes back to the console, and the fault comes
    Bench bench(
        scripted("60", {"scenario.fault=[{time_s = 3, what = \"adc_a_high\", until_s = 3.1}]"}));
    bench.follower.connect();
    bench.pass(1);
    leave_alone(bench, SILENCE_S);
    bench.pass(2 * RESYNC_S);
    TEST_ASSERT_EQUAL_MESSAGE(DRIVE_STATE_FAULT, bench.log.states.back(), bench.all_said().c_str());
    TEST_ASSERT_EQUAL_STRING("the recording of a fault is kept until it is read",
                             bench.follower.no_stream().c_str());
    TEST_ASSERT_EQUAL(FAULT_ADC_SATURATED, recorded(bench).fault().id);
    bench.pass(RESYNC_S);
    TEST_ASSERT_TRUE_MESSAGE(bench.follower.shadow().is_in_step(), bench.all_said().c_str());
}

TEST(a_key_of_the_image_is_refused_and_a_refused_key_is_named)
{
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(SETTLES_S);
    TEST_ASSERT_EQUAL(0, bench.refusal_of("set motor.pole_pairs=1").find("motor.pole_pairs: "));
    for (const char *set : {"set board.recorder_entries=2048", "set board.baud=230400",
                            "set motor.name=\"another\""}) {
        TEST_ASSERT_TRUE(bench.refusal_of(set).find("is in the image only: build and flash") !=
                         std::string::npos);
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, bench.log.states.back());
}

// A board whose drive rests, and which is asked.
struct Resting : Bench {
    Resting() : Bench(scripted("60"))
    {
        follower.connect();
        pass(0.1);
        do_line("stop");
        pass(0.1);
    }

    std::string text_of(const std::string &typed)
    {
        const nf::debug::Answer answer = commands.execute(typed);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::done, answer.outcome, answer.text.c_str());
        return answer.text;
    }
};

struct TemporaryFile {
    std::string path = (std::filesystem::temp_directory_path() / fmt::format("block{}", getpid()));

    ~TemporaryFile()
    {
        std::filesystem::remove(path);
    }
};

TEST(several_keys_are_one_change_and_can_be_read_back)
{
    Resting bench;
    const uint32_t before = bench.follower.block_in_force().cfg.crc;
    const std::string shown = bench.text_of("get observer");
    bench.do_line("set observer.kappa=0.024 speed_loop.ramp_rpm_s=700");
    bench.pass(1);
    TEST_ASSERT_TRUE(shown != bench.text_of("get observer"));
    TEST_ASSERT_EQUAL(1, bench.follower.shadow().run(1)->changes.size());
    TEST_ASSERT_TRUE(before != bench.follower.block_in_force().cfg.crc);
    TEST_ASSERT_TRUE(bench.refusal_of("get no.such").find("no.such") != std::string::npos);
    // One of them is wrong: none acts.
    const uint32_t now = bench.follower.block_in_force().cfg.crc;
    bench.refusal_of("set observer.kappa=0.03 speed_loop.ramp_rpm_s=-1");
    TEST_ASSERT_EQUAL_UINT32(now, bench.follower.block_in_force().cfg.crc);
    TEST_ASSERT_EQUAL(0, bench.refusal_of("set observer.kappa=0.03 board.baud=230400")
                             .find("observer.kappa, board.baud "));
}

TEST(who_comes_later_sets_other_keys_and_keeps_what_was_set)
{
    Resting bench;
    bench.do_line("set observer.kappa=0.024");
    BoardCommands later(bench.follower, {},
                        {[](const std::string &) {}, [&](double seconds) { bench.pass(seconds); },
                         [](const nf::RecordedRun &) { return true; }});
    TEST_ASSERT_EQUAL(nf::debug::Outcome::done,
                      later.execute("set speed_loop.ramp_rpm_s=700").outcome);
    const nf::debug::Answer over = later.execute("set observer.kappa=0.03");
    TEST_ASSERT_EQUAL(nf::debug::Outcome::refused, over.outcome);
    TEST_ASSERT_TRUE_MESSAGE(over.text.find("observer.") == 0, over.text.c_str());
    // What both have set is what one would have.
    const uint32_t both = bench.follower.block_in_force().cfg.crc;
    Resting other;
    other.do_line("set observer.kappa=0.024 speed_loop.ramp_rpm_s=700");
    TEST_ASSERT_EQUAL_UINT32(other.follower.block_in_force().cfg.crc, both);
}

TEST(a_dump_is_loaded_on_another_board_and_a_file_is_neither_replaced_nor_believed)
{
    const TemporaryFile file;
    Resting one;
    one.do_line("set observer.kappa=0.024");
    one.do_line("dump " + file.path);
    TEST_ASSERT_EQUAL_UINT(0, one.refusal_of("dump " + file.path).find(file.path));
    Resting other;
    other.do_line("load " + file.path);
    const config_block_t loaded = other.follower.block_in_force();
    const config_block_t dumped = one.follower.block_in_force();
    TEST_ASSERT_EQUAL_MEMORY(&dumped, &loaded, sizeof dumped);
    std::ofstream(file.path, std::ios::app) << "more";
    TEST_ASSERT_EQUAL_UINT(0, other.refusal_of("load " + file.path).find(file.path));
    TEST_ASSERT_TRUE(other.refusal_of("load no/such").find("no/such") != std::string::npos);
    TEST_ASSERT_EQUAL_UINT32(loaded.cfg.crc, other.follower.block_in_force().cfg.crc);
}

TEST(a_store_waits_for_a_rotor_that_comes_to_rest_and_not_for_one_that_is_driven)
{
    Bench bench(scripted("60"));
    bench.follower.connect();
    bench.pass(2);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, bench.log.states.back());
    const double begun_s = bench.line.now_s();
    TEST_ASSERT_TRUE(bench.refusal_of("store").find("stop it first") != std::string::npos);
    TEST_ASSERT_TRUE(bench.line.now_s() < begun_s + 1);
    bench.do_line("stop");
    bench.do_line("store");
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
