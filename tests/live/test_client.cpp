// SPDX-License-Identifier: MIT
// Frames and the client: a question is asked until its own answer comes, and whatever else comes in changes nothing.
#include "client.h"

#include <deque>
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

// A board that answers as it is told, on a clock that only waiting moves.
class FakeBoard : public nf::live::Channel
{
public:
    std::vector<uint8_t> read(double wait_s) override
    {
        if (to_pc.empty()) {
            now += wait_s;
            return {};
        }
        Bytes bytes = to_pc.front();
        to_pc.pop_front();
        return bytes;
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        for (const Message &question : reader.add(bytes)) {
            questions.push_back(question);
            if (answer) {
                answer(question);
            }
        }
    }
    double now_s() const override
    {
        return now;
    }
    void say(const Message &message)
    {
        to_pc.push_back(frame_of(message));
    }

    std::function<void(const Message &)> answer;
    std::vector<Message> questions;
    std::deque<Bytes> to_pc;
    FrameReader reader;
    double now = 0;
};

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
        const Bytes health = nf::live::BodyWriter().u32(0).u32(0).u32(0).u32(77).body();
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

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
