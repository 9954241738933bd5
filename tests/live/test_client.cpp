// SPDX-License-Identifier: MIT
// Frames and the client: a question is asked until its own answer comes, and whatever else comes in
// changes nothing.
#include "fake_board.h"

#include <random>

extern "C" {
#include "testing.h"
}

namespace
{

using nf::live::Bytes;
using nf::live::Client;
using nf::live::FrameReader;
using nf::live::LinkError;
using nf::live::Message;

constexpr nf::live::Timing TIMING = {0.05, 3, 0.02};

Message answer_to(const Message &question, const std::string &verdict, uint32_t ticket = 0)
{
    return {static_cast<uint8_t>(question.type + LINK_ANSWER), question.tag,
            nf::live::BodyWriter().u32(ticket).text(verdict).body()};
}

std::string refusal(const std::function<void()> &ask)
{
    try {
        ask();
    } catch (const LinkError &error) {
        return error.what();
    }
    return "";
}

// Where a command carries its ticket, and a line.
uint32_t ticket_of(const Message &question)
{
    const std::size_t at = question.type == LINK_COMMAND ? 6 : 0;
    const Bytes ticket(question.body.begin() + static_cast<std::ptrdiff_t>(at),
                       question.body.end());
    return nf::live::BodyReader(ticket).u32();
}

TEST(a_frame_has_no_zero_within_and_is_read_back)
{
    std::mt19937 random(1);
    for (std::size_t length = 0; length <= LINK_MESSAGE_BYTES_MAX - 2; length++) {
        Message message{7, 9, Bytes(length)};
        for (uint8_t &byte : message.body) {
            byte = static_cast<uint8_t>(random() % 3); // many zeros
        }
        const Bytes frame = frame_of(message);
        for (std::size_t k = 1; k + 1 < frame.size(); k++) {
            TEST_ASSERT_NOT_EQUAL(0, frame[k]);
        }
        const std::vector<Message> found = FrameReader().add(frame);
        TEST_ASSERT_EQUAL(1, found.size());
        TEST_ASSERT_TRUE(found[0].body == message.body && found[0].type == 7 && found[0].tag == 9);
    }
}

TEST(a_changed_dropped_or_doubled_byte_loses_the_frame_and_not_the_next)
{
    const Message message{LINK_FRAMES, 0, Bytes(100, 3)};
    const Bytes good = frame_of(message);
    for (std::size_t k = 1; k + 1 < good.size(); k++) {
        Bytes changed = good;
        changed[k] = static_cast<uint8_t>(changed[k] ^ 0x40U);
        Bytes dropped = good;
        dropped.erase(dropped.begin() + static_cast<std::ptrdiff_t>(k));
        Bytes doubled = good;
        doubled.insert(doubled.begin() + static_cast<std::ptrdiff_t>(k), good[k]);
        for (const Bytes &bad : {changed, dropped, doubled}) {
            FrameReader reader;
            TEST_ASSERT_EQUAL(0, reader.add(bad).size());
            TEST_ASSERT_EQUAL(1, reader.add(good).size());
        }
    }
}

TEST(any_bytes_are_read_without_a_message_of_their_own)
{
    std::mt19937 random(2);
    FrameReader reader;
    for (int k = 0; k < 1000; k++) {
        Bytes bytes(300);
        for (uint8_t &byte : bytes) {
            byte = static_cast<uint8_t>(random());
        }
        TEST_ASSERT_EQUAL(0, reader.add(bytes).size()); // a CRC of 32 bits
    }
}

TEST(a_question_without_an_answer_is_asked_again_with_its_tag)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        if (board.questions.size() == 2) {
            board.say(answer_to(question, ""));
        }
    };
    Client client(board, TIMING, {});
    TEST_ASSERT_EQUAL_STRING("", client.store().c_str());
    TEST_ASSERT_EQUAL(2, board.questions.size());
    TEST_ASSERT_EQUAL(board.questions[0].tag, board.questions[1].tag);
    TEST_ASSERT_EQUAL(1, client.repeats());
}

TEST(a_board_that_never_answers_is_said_after_all_tries)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    try {
        (void)client.store();
        TEST_FAIL();
    } catch (const LinkError &error) {
        TEST_ASSERT_EQUAL_STRING("the board does not answer: `store` was asked 3 times in 0.15 s",
                                 error.what());
    }
    TEST_ASSERT_EQUAL(TIMING.tries, board.questions.size());
}

TEST(an_answer_to_a_question_before_is_none)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        Message late = answer_to(question, "late");
        late.tag = static_cast<uint8_t>(late.tag - 1);
        board.say(late);
        board.say(answer_to(question, "in time"));
    };
    Client client(board, TIMING, {});
    TEST_ASSERT_EQUAL_STRING("in time", client.store().c_str());
}

TEST(what_the_board_says_meanwhile_goes_to_the_listener)
{
    FakeBoard board;
    std::string text;
    board.answer = [&](const Message &question) {
        board.say({LINK_TEXT, 0, {'h', 'i'}});
        board.say(answer_to(question, ""));
    };
    nf::live::Listener listener;
    listener.text = [&](const std::string &characters) { text += characters; };
    Client client(board, TIMING, listener);
    (void)client.store();
    TEST_ASSERT_EQUAL_STRING("hi", text.c_str());
}

TEST(a_question_that_the_board_does_not_know_is_said)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        board.say({LINK_REFUSED, question.tag, {question.type}});
    };
    Client client(board, TIMING, {});
    try {
        (void)client.store();
        TEST_FAIL();
    } catch (const LinkError &error) {
        TEST_ASSERT_EQUAL_STRING("the board does not know `store`: another firmware?",
                                 error.what());
    }
}

TEST(a_command_carries_the_ticket_of_the_last_answer)
{
    FakeBoard board;
    uint32_t ticket = 100;
    board.answer = [&](const Message &question) { board.say(answer_to(question, "", ++ticket)); };
    Client client(board, TIMING, {});
    (void)client.store();
    (void)client.command({1000, DRIVE_MODE_SPEED, DRIVE_REQUEST_RUN});
    (void)client.line("status");
    TEST_ASSERT_EQUAL(101, ticket_of(board.questions[1]));
    TEST_ASSERT_EQUAL(102, ticket_of(board.questions[2]));
}

// A fault is seen before its ticket is known.
TEST(a_clear_asks_for_the_ticket_first)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        const bool pings = question.type == LINK_PING;
        const Bytes health = nf::live::BodyWriter().u32(0).u32(0).u32(0).u16(0).u32(77).body();
        board.say(pings ? Message{LINK_PING + LINK_ANSWER, question.tag, health}
                        : answer_to(question, ""));
    };
    Client client(board, TIMING, {});
    (void)client.command({0, DRIVE_MODE_SPEED, DRIVE_REQUEST_CLEAR});
    TEST_ASSERT_EQUAL(2, board.questions.size());
    TEST_ASSERT_EQUAL(77, ticket_of(board.questions[1]));
}

TEST(a_verdict_without_a_ticket_is_none)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        board.say({static_cast<uint8_t>(question.type + LINK_ANSWER), question.tag, {'o', 'k'}});
    };
    Client client(board, TIMING, {});
    TEST_ASSERT_EQUAL_STRING(
        "the board's answer to `store` is none of this link: another firmware?",
        refusal([&] { (void)client.store(); }).c_str());
}

TEST(a_piece_of_the_ring_is_asked_for_once)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    TEST_ASSERT_FALSE(client.state(5, 0, 8).answered);
    TEST_ASSERT_EQUAL(Client::Again::silence, client.again(5, 0, 16));
    TEST_ASSERT_EQUAL(2, board.questions.size());
}

// A segment, the first word, and two words.
Bytes piece(uint32_t segment, uint16_t first)
{
    return nf::live::BodyWriter().u32(segment).u16(first).u8(2).u32(7).u32(8).body();
}

TEST(a_piece_of_another_segment_or_place_is_none)
{
    FakeBoard board;
    Bytes body;
    board.answer = [&](const Message &question) {
        board.say({static_cast<uint8_t>(question.type + LINK_ANSWER), question.tag, body});
    };
    Client client(board, TIMING, {});
    const std::pair<Bytes, std::size_t> cases[] = {
        {piece(5, 3), 2}, {piece(6, 3), 0}, {piece(5, 4), 0}};
    for (const auto &[answer, words] : cases) {
        body = answer;
        const Client::Piece found = client.state(5, 3, 2);
        TEST_ASSERT_TRUE(found.answered);
        TEST_ASSERT_EQUAL(words, found.words.words.size());
    }
}

TEST(words_of_the_block_from_another_place_or_fewer_are_refused)
{
    FakeBoard board;
    board.answer = [&](const Message &question) {
        const Bytes words = nf::live::BodyWriter().u16(3).u8(1).u32(7).body();
        board.say({LINK_READ + LINK_ANSWER, question.tag, words});
    };
    Client client(board, TIMING, {});
    TEST_ASSERT_EQUAL_UINT32(7, client.read(3, 1).words[0]);
    TEST_ASSERT_TRUE(!refusal([&] { (void)client.read(4, 1); }).empty());
    TEST_ASSERT_TRUE(!refusal([&] { (void)client.read(3, 2); }).empty());
}

TEST(an_answer_without_a_byte_of_code_or_a_refusal_has_no_entries)
{
    FakeBoard board;
    Message answer;
    board.answer = [&](const Message &question) {
        answer.tag = question.tag;
        board.say(answer);
    };
    Client client(board, TIMING, {});
    const std::pair<Message, Client::Again> cases[] = {
        {{LINK_AGAIN + LINK_ANSWER, 0, Bytes(7)}, Client::Again::nothing},
        {{LINK_AGAIN + LINK_ANSWER, 0, Bytes(8)}, Client::Again::entries},
        {{LINK_REFUSED, 0, {LINK_AGAIN}}, Client::Again::nothing}};
    for (const auto &[told, expected] : cases) {
        answer = told;
        TEST_ASSERT_EQUAL(expected, client.again(5, 0, 16));
    }
}

// ---- how long an answer is waited for ----

constexpr double ROUNDED_S = 1e-9; // a few sums of seconds

void expect_wait(double expected_s, FakeBoard &board, const std::function<void()> &ask)
{
    const double from_s = board.now;
    ask();
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED_S, expected_s, board.now - from_s);
}

// Of both ways to ask, at a board that does not answer.
void expect_waits(double once_s, double patient_s, uint32_t baud)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    client.has_rate(baud);
    expect_wait(once_s, board, [&] { (void)client.state(5, 0, 8); });
    expect_wait(TIMING.tries * patient_s, board,
                [&] { (void)refusal([&] { (void)client.store(); }); });
}

// 10000 baud carry 1000 bytes in a second. Around a message are 7 bytes: CRC, delimiters and COBS.
// The board may be sending the longest message when the question comes, and answer with another
// one; a question that is asked once has 16 bytes at most.
TEST(a_slow_line_is_waited_for_as_long_as_it_takes_and_a_fast_one_no_less)
{
    const double longest_s = (LINK_MESSAGE_BYTES_MAX + 7) / 1000.0;
    expect_waits((16 + 7) / 1000.0 + 2 * longest_s, 3 * longest_s, 10000);
    expect_waits(TIMING.ring_s, TIMING.answer_s, 1000000);
    expect_waits(TIMING.ring_s, TIMING.answer_s, 0);
}

void ask_once(Client &client)
{
    (void)client.state(5, 0, 8);
}

// The answer to the last question, which is not waited for any more.
void answer_late(FakeBoard &board)
{
    board.say({LINK_STATE + LINK_ANSWER, board.questions.back().tag, piece(5, 0)});
}

TEST(an_answer_that_comes_late_doubles_the_wait_for_the_next_ones_once)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    expect_wait(TIMING.ring_s, board, [&] { ask_once(client); });
    answer_late(board);
    answer_late(board);
    client.poll(0);
    client.poll(0);
    expect_wait(2 * TIMING.ring_s, board, [&] { ask_once(client); });
    board.say({LINK_REFUSED, board.questions.back().tag, {LINK_STATE}});
    client.poll(0);
    expect_wait(4 * TIMING.ring_s, board, [&] { ask_once(client); });
}

// The wait behind so many late answers that it grows no further.
void expect_longest_wait(double expected_s, uint32_t baud)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    client.has_rate(baud);
    for (int k = 0; k < 6; k++) {
        ask_once(client);
        answer_late(board);
        client.poll(0);
    }
    expect_wait(expected_s, board, [&] { ask_once(client); });
}

// The ring has no more than some tenths of a second. A line that takes longer anyway is waited for
// as before.
TEST(late_answers_are_waited_for_no_longer_than_0_3_s_unless_the_line_takes_longer)
{
    expect_longest_wait(0.3, 0);
    expect_longest_wait((16 + 7 + 2 * (LINK_MESSAGE_BYTES_MAX + 7)) / 1000.0, 10000);
}

// There are 255 tags. One whose answer never came is another question's later on.
TEST(an_answer_in_time_to_a_tag_that_was_given_up_once_is_not_late)
{
    FakeBoard board;
    Client client(board, TIMING, {});
    ask_once(client);
    board.answer = [&](const Message &question) { board.say(answer_to(question, "")); };
    for (int k = 0; k < 255; k++) {
        (void)client.store();
    }
    TEST_ASSERT_EQUAL(board.questions.front().tag, board.questions.back().tag);
    board.answer = nullptr;
    expect_wait(TIMING.ring_s, board, [&] { ask_once(client); });
}

// It may have been the answer. What is asked again is waited for all the same.
TEST(a_damaged_frame_ends_the_wait_for_what_is_asked_once)
{
    FakeBoard board;
    board.answer = [&](const Message &) { board.to_pc.push_back({0, 1, 1, 0}); };
    Client client(board, TIMING, {});
    expect_wait(0, board, [&] { ask_once(client); });
    expect_wait(TIMING.tries * TIMING.answer_s, board,
                [&] { (void)refusal([&] { (void)client.store(); }); });
}

TEST(a_frame_beyond_the_longest_is_broken_and_the_next_one_is_read)
{
    FrameReader reader;
    Bytes longer(LINK_MESSAGE_BYTES_MAX + 20, 1);
    longer.back() = 0;
    TEST_ASSERT_EQUAL(0, reader.add(longer).size());
    TEST_ASSERT_EQUAL(1, reader.broken());
    TEST_ASSERT_EQUAL(1, reader.add(nf::live::frame_of({7, 9, {1}})).size());
    TEST_ASSERT_EQUAL(1, reader.whole());
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
