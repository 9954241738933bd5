// SPDX-License-Identifier: MIT
// The patience of a follower: when its messages are short, when it asks anew who the board is, and
// how often it says so.
#include "fake_board.h"

#include "block.h"
#include "follower.h"
#include "identity.h"

extern "C" {
#include "drive_words.h"
#include "testing.h"
}

#include <algorithm>

#include <fmt/format.h>

namespace
{

using nf::live::BodyWriter;
using nf::live::Bytes;
using nf::live::Follower;
using nf::live::FollowerOptions;
using nf::live::LinkError;
using nf::live::Message;

constexpr double STEP_S = 0.01;
constexpr uint16_t SEGMENT_ENTRIES = 304;
constexpr uint32_t TICK_PS = 100000000;
constexpr double NEVER_S = 1e9;

const std::vector<std::string> NO_TIMEOUT = {"tuning.command_timeout_s=0"};

class NoTicks : public nf::TickSink
{
public:
    void add(const nf::Tick & /*tick*/) override
    {
    }
};

// A board that says who it is, has a block, and counts what it is asked.
struct Bench {
    explicit Bench(const FollowerOptions &options, const std::vector<std::string> &set = NO_TIMEOUT)
        : block(nf::make_block(nf::load_parts("motor_a", "bench_310v", "any", {}, set))),
          follower(board, ticks,
                   {[this](const std::string &text) { said.push_back({board.now, text}); },
                    [](const std::string &) {}},
                   options)
    {
        board.answer = [this](const Message &question) { answer(question); };
        follower.connect();
    }

    Bytes identity() const
    {
        BodyWriter body;
        body.u8(LINK_VERSION).u8(LINK_CAN_STREAM);
        body.u16(drive_words_count()).u16(CONFIG_BLOCK_WORDS).u16(SEGMENT_ENTRIES);
        body.u32(nf::schema_hash()).u32(block.identity.board).u32(TICK_PS);
        body.u32(0).u32(20000000).u32(450000000); // baud, A and V
        for (int k = 0; k < 6; k++) {
            body.u32(0); // build, ticket
        }
        return body.body();
    }

    Bytes words(const Message &question) const
    {
        nf::live::BodyReader reader(question.body);
        const uint16_t first = reader.u16();
        const uint8_t count = reader.u8();
        BodyWriter body;
        body.u16(first).u8(count);
        for (uint32_t k = 0; k < count; k++) {
            body.u32(config_block_word(&block, first + k));
        }
        return body.body();
    }

    void answer(const Message &question)
    {
        asked.push_back({board.now, question.type});
        if (question.type == LINK_STREAM) {
            streams.push_back(question.body[0]);
        }
        const bool pings = question.type == LINK_PING;
        if (mute || question.type == LINK_STATE || (pings && !answers_pings)) {
            return;
        }
        const Bytes body = question.type == LINK_HELLO  ? identity()
                           : question.type == LINK_READ ? words(question)
                           : pings ? BodyWriter().u32(0).u32(0).u32(0).u16(0).u32(0).body()
                                   : BodyWriter().u32(0).text(no_stream).body();
        board.say({static_cast<uint8_t>(question.type + LINK_ANSWER), question.tag, body});
    }

    void pass(double seconds)
    {
        for (const double until_s = board.now + seconds; board.now < until_s;) {
            const double before_s = board.now;
            follower.step(STEP_S);
            board.now = std::max(board.now, before_s + STEP_S);
        }
    }

    // So many frames that come between two looks at the line, which are 0.25 s apart at least.
    void judge(int whole, int broken)
    {
        constexpr double APART_S = 0.26;
        for (int k = 0; k < whole; k++) {
            board.say({LINK_TEXT, 0, {}});
        }
        board.to_pc.insert(board.to_pc.end(), static_cast<std::size_t>(broken), {0, 1, 1, 0});
        while (!board.to_pc.empty()) {
            follower.step(0);
        }
        board.now += APART_S;
        follower.step(0);
    }

    std::vector<double> times_of(uint8_t type) const
    {
        std::vector<double> times;
        for (const auto &[now_s, question] : asked) {
            if (question == type) {
                times.push_back(now_s);
            }
        }
        return times;
    }

    std::vector<double> times_of(const std::string &text) const
    {
        std::vector<double> times;
        for (const auto &[now_s, line] : said) {
            if (line.find(text) == 0) {
                times.push_back(now_s);
            }
        }
        return times;
    }

    config_block_t block;
    FakeBoard board;
    NoTicks ticks;
    bool mute = false;
    bool answers_pings = true;
    std::string no_stream;
    std::vector<std::pair<double, uint8_t>> asked;
    std::vector<std::pair<double, std::string>> said;
    std::vector<int> streams; // entries of a message that were asked for, in turn
    Follower follower;
};

constexpr FollowerOptions WITHOUT_PINGS = {{0.05, 3, 0.02}, 10, NEVER_S, NEVER_S};
constexpr FollowerOptions PINGING = {{0.05, 3, 0.02}, 10, 0.2, 1};
constexpr int FULL = 1;
constexpr int SHORT = 16;

void expect_streams(const std::vector<int> &expected, const Bench &bench)
{
    TEST_ASSERT_EQUAL_STRING(fmt::format("{}", fmt::join(expected, " ")).c_str(),
                             fmt::format("{}", fmt::join(bench.streams, " ")).c_str());
}

TEST(messages_become_short_on_a_line_that_spoils_more_than_one_in_ten)
{
    Bench bench(WITHOUT_PINGS);
    bench.judge(0, 0);
    bench.judge(95, 10);
    expect_streams({FULL}, bench);
    bench.judge(85, 10);
    expect_streams({FULL, SHORT}, bench);
}

// Between both they stay what they are. The answer to the question for other messages is one of the
// next frames.
TEST(short_messages_become_long_on_a_line_that_spoils_less_than_one_in_fifty)
{
    Bench bench(WITHOUT_PINGS);
    bench.judge(0, 0);
    bench.judge(0, 1);
    expect_streams({FULL, SHORT}, bench);
    bench.judge(40, 2);
    bench.judge(48, 1);
    expect_streams({FULL, SHORT}, bench);
    bench.judge(51, 1);
    expect_streams({FULL, SHORT, FULL}, bench);
    bench.judge(48, 1);
    expect_streams({FULL, SHORT, FULL}, bench);
}

TEST(a_line_is_judged_four_times_a_second_and_not_at_each_pass)
{
    Bench bench(WITHOUT_PINGS);
    bench.judge(0, 0);
    bench.board.to_pc.push_back({0, 1, 1, 0});
    bench.pass(0.2);
    expect_streams({FULL}, bench);
    bench.pass(0.1);
    expect_streams({FULL, SHORT}, bench);
}

TEST(a_stream_that_is_held_up_is_asked_for_again_until_it_begins_and_said_once)
{
    Bench bench(WITHOUT_PINGS);
    bench.no_stream = "a reason";
    bench.judge(0, 0);
    bench.judge(0, 1); // short ones
    bench.judge(0, 0); // long ones
    bench.judge(0, 0);
    expect_streams({FULL, SHORT, FULL, FULL}, bench);
    TEST_ASSERT_EQUAL_STRING("a reason", bench.follower.no_stream().c_str());
    TEST_ASSERT_EQUAL(1, bench.times_of("no stream: a reason").size());
    bench.no_stream = "";
    bench.judge(0, 0);
    bench.judge(0, 0);
    expect_streams({FULL, SHORT, FULL, FULL, FULL}, bench);
    TEST_ASSERT_EQUAL_STRING("", bench.follower.no_stream().c_str());
}

// It was heard with a ping, which is up to a fifth of a second ago, and is missed with one, which
// is waited for.
TEST(a_board_that_is_not_heard_for_a_second_is_asked_who_it_is)
{
    constexpr double SILENT_FROM_S = 3;
    Bench bench(PINGING);
    bench.pass(SILENT_FROM_S);
    TEST_ASSERT_EQUAL(1, bench.times_of(LINK_HELLO).size());
    bench.mute = true;
    try {
        bench.pass(2);
        TEST_FAIL();
    } catch (const LinkError &) {
    }
    const double after_s = bench.times_of(LINK_HELLO)[1] - SILENT_FROM_S;
    TEST_ASSERT_TRUE(after_s > PINGING.silent_s - PINGING.ping_s - STEP_S);
    TEST_ASSERT_TRUE(after_s <
                     PINGING.silent_s + PINGING.ping_s + PINGING.timing.ring_s + 2 * STEP_S);
}

TEST(a_board_that_says_anything_is_not_asked_who_it_is)
{
    Bench bench(PINGING);
    bench.answers_pings = false;
    for (int k = 0; k < 20; k++) {
        bench.board.say({LINK_TEXT, 0, {}});
        bench.pass(0.5 * PINGING.silent_s);
    }
    TEST_ASSERT_EQUAL(1, bench.times_of(LINK_HELLO).size());
}

// A passing of time is up to a step longer than it has to be.
void expect_pings(double apart_s, const std::vector<std::string> &set)
{
    constexpr double WATCHED_S = 4;
    Bench bench(PINGING, set);
    bench.pass(WATCHED_S);
    const auto count = static_cast<double>(bench.times_of(LINK_PING).size());
    TEST_ASSERT_TRUE(count <= WATCHED_S / apart_s + 1);
    TEST_ASSERT_TRUE(count >= WATCHED_S / (apart_s + STEP_S) - 1);
}

TEST(a_board_that_stops_its_motor_without_a_message_hears_four_in_that_time)
{
    expect_pings(PINGING.ping_s, NO_TIMEOUT);
    expect_pings(0.4 / 4, {"tuning.command_timeout_s=0.4"});
    expect_pings(PINGING.ping_s, {"tuning.command_timeout_s=8"});
}

// A new one each tenth of a second, and the one before is overwritten: none is shown.
TEST(ticks_that_are_not_shown_are_told_after_a_second_and_each_five_seconds)
{
    constexpr double LATE_S = 0.2; // the next pass that sees one overwritten
    Bench bench(PINGING);
    for (uint32_t number = 1; bench.board.now < 12.5; number += RECORDER_SEGMENTS) {
        bench.board.say({LINK_SEGMENT, 0,
                         BodyWriter().u32(number).u32(number).u32(0).u32(0).u16(0).u8(0).body()});
        bench.pass(0.1);
    }
    const std::vector<double> times = bench.times_of("not in step: ");
    TEST_ASSERT_EQUAL(3, times.size());
    for (std::size_t k = 0; k < times.size(); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(LATE_S * static_cast<double>(k + 1),
                                  1 + 5.0 * static_cast<double>(k), times[k]);
    }
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
