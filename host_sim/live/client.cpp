// SPDX-License-Identifier: MIT
#include "client.h"

#include "line_rate.h"
#include "recording.h"

#include <algorithm>
#include <random>
#include <utility>

extern "C" {
#include "frame_code.h"
#include "input_signal.h"
#include "source.h"
}

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr uint8_t TAG_UNASKED = 0;
constexpr uint8_t TAG_MAX = 255;
constexpr uint8_t AGAIN_ANSWER = LINK_AGAIN + LINK_ANSWER;

const char *name_of(link_question_t type)
{
    switch (type) {
    case LINK_HELLO:
        return "hello";
    case LINK_BYE:
        return "bye";
    case LINK_PING:
        return "ping";
    case LINK_COMMAND:
        return "command";
    case LINK_LINE:
        return "line";
    case LINK_READ:
        return "read";
    case LINK_WRITE:
        return "write";
    case LINK_APPLY:
        return "apply";
    case LINK_STORE:
        return "store";
    case LINK_DEFAULTS:
        return "defaults";
    case LINK_STREAM:
        return "stream";
    case LINK_STATE:
        return "state";
    case LINK_AGAIN:
        return "again";
    case LINK_BOX:
        return "box";
    }
    return "question";
}

[[noreturn]] void refuse_answer(link_question_t type)
{
    throw LinkError(fmt::format(
        "the board's answer to `{}` is none of this link: another firmware?", name_of(type)));
}

Words words_of(BodyReader &reader, link_question_t type)
{
    Words words{reader.u16(), {}};
    const uint8_t count = reader.u8();
    for (unsigned k = 0; k < count && reader.is_good(); k++) {
        words.words.push_back(reader.u32());
    }
    if (!reader.is_done()) {
        refuse_answer(type);
    }
    return words;
}

// Of the flags of a health.
std::string who(uint8_t flags)
{
    return source_name(
        static_cast<source_t>((flags >> LINK_HEALTH_SOURCE) & LINK_HEALTH_SOURCE_MASK));
}

std::string why_lost(uint8_t flags)
{
    const uint32_t lost = (flags >> LINK_HEALTH_INPUT) & LINK_HEALTH_INPUT_MASK;
    return lost == INPUT_LOST_NOT ? "" : input_signal_text(lost);
}

} // namespace

Client::Client(Channel &channel, const Timing &timing, Listener listener)
    : channel_(channel), timing_(timing), listener_(std::move(listener))
{
}

void Client::has_rate(uint32_t baud)
{
    constexpr double AROUND = LINK_CRC_BYTES + 3; // delimiters and COBS
    constexpr double MESSAGE = LINK_MESSAGE_BYTES_MAX + AROUND;
    constexpr double SHORT = 16 + AROUND; // the longest question that is asked once
    // The question, what the board is just sending, the answer.
    const auto time_s = [&](double question) {
        return (question + 2 * MESSAGE) * BITS_OF_A_BYTE / baud;
    };
    if (baud != 0) {
        timing_.ring_s = std::max(timing_.ring_s, time_s(SHORT));
        timing_.answer_s = std::max(timing_.answer_s, time_s(MESSAGE));
    }
}

void Client::poll(double wait_s)
{
    const Bytes bytes = channel_.read(wait_s);
    bytes_in_ += bytes.size();
    for (const Message &message : reader_.add(bytes)) {
        take(message);
    }
}

// On a line of an adapter that collects bytes, answers come behind the time that they were waited
// for: the next is waited for longer.
void Client::notice_late(const Message &message)
{
    constexpr double LONGEST_S = 0.3; // the drive's ring has no more than some tenths
    const bool is_answer = message.type == LINK_REFUSED || message.type >= LINK_ANSWER;
    if (is_answer && given_up_.test(message.tag)) {
        given_up_.reset(message.tag);
        timing_.ring_s = std::min(2 * timing_.ring_s, std::max(timing_.ring_s, LONGEST_S));
    }
}

void Client::take(const Message &message)
{
    notice_late(message);
    const bool asked = !answered_ && message.tag == awaited_.tag && message.tag != TAG_UNASKED;
    if (message.type == AGAIN_ANSWER || message.type == LINK_FRAMES) {
        take_frames(message.body);
    }
    if (message.type == LINK_TEXT) {
        listener_.text(text_of(message.body));
    } else if (message.type == LINK_SEGMENT) {
        take_segment(message.body);
    } else if (asked && (message.type == awaited_.type || message.type == LINK_REFUSED)) {
        refused_ = message.type == LINK_REFUSED;
        awaited_.body = message.body;
        answered_ = true;
    }
}

void Client::take_segment(const Bytes &body)
{
    BodyReader reader(body);
    const SegmentInfo info = {reader.u32(), reader.u32(), reader.u32(),
                              reader.u32(), reader.u16(), reader.u8() != 0};
    if (reader.is_done()) {
        listener_.segment(info);
    }
}

void Client::take_frames(const Bytes &body)
{
    BodyReader reader(body);
    Entries frames{reader.u32(), reader.u16(), {}};
    const uint8_t count = reader.u8();
    if (!reader.is_good() || count == 0 || count > FRAME_CODE_ENTRIES_MAX) {
        return;
    }
    const Bytes code = reader.rest();
    frames.entries.resize(count);
    if (frame_code_decode(code.data(), static_cast<uint32_t>(code.size()), frames.entries.data(),
                          count)) {
        listener_.entries(frames);
    }
}

void Client::wait_for_answer(const Question &question)
{
    const double until_s = channel_.now_s() + question.answer_s;
    const uint64_t broken = reader_.broken();
    while (!answered_ && channel_.now_s() < until_s &&
           (!question.impatient || reader_.broken() == broken)) {
        poll(until_s - channel_.now_s());
    }
}

// Asked again it has the same tag: the board may know that it has done it already.
Bytes Client::ask(const Question &question)
{
    const auto tag = static_cast<uint8_t>(awaited_.tag % TAG_MAX + 1);
    const Bytes frame = frame_of({static_cast<uint8_t>(question.type), tag, question.body});
    awaited_ = {static_cast<uint8_t>(uint32_t{question.type} + LINK_ANSWER), tag, {}};
    given_up_.reset(tag);
    answered_ = false;
    refused_ = false;
    for (unsigned k = 0; k < question.tries && !answered_; k++) {
        repeats_ += k == 0 ? 0 : 1;
        channel_.write(frame);
        wait_for_answer(question);
    }
    if (!answered_) {
        given_up_.set(tag);
        throw LinkError(fmt::format(
            "the board does not answer: `{}` was asked {} times in {:.2g} s",
            name_of(question.type), question.tries, question.tries * question.answer_s));
    }
    if (refused_) {
        throw LinkError(
            fmt::format("the board does not know `{}`: another firmware?", name_of(question.type)));
    }
    return awaited_.body;
}

std::string Client::verdict(link_question_t type, const Bytes &body)
{
    const Bytes answer = ask(patient(type, body));
    BodyReader reader(answer);
    ticket_ = reader.u32();
    if (!reader.is_good()) {
        refuse_answer(type);
    }
    return text_of(reader.rest());
}

Identity Client::hello()
{
    const uint32_t salt = std::random_device{}();
    const Bytes body = ask(patient(LINK_HELLO, BodyWriter().u8(LINK_VERSION).u32(salt).body()));
    BodyReader reader(body);
    Identity identity{};
    identity.version = reader.u8();
    identity.capabilities = reader.u8();
    identity.state_words = reader.u16();
    identity.block_words = reader.u16();
    identity.segment_entries = reader.u16();
    identity.config = {reader.u32(), reader.u32()};
    identity.tick_ps = reader.u32();
    identity.baud = reader.u32();
    identity.current_full_scale_ua = reader.u32();
    identity.bus_full_scale_uv = reader.u32();
    std::generate(identity.build.begin(), identity.build.end(), [&] { return reader.u8(); });
    ticket_ = reader.u32();
    // Another version may have more or less in it: the caller says so.
    if (body.empty() || (identity.version == LINK_VERSION && !reader.is_done())) {
        refuse_answer(LINK_HELLO);
    }
    return identity;
}

void Client::bye()
{
    (void)ask(patient(LINK_BYE));
}

namespace
{

std::string reset_of(BodyReader &reader)
{
    const auto reason = static_cast<hal_reset_reason_t>(reader.u8());
    return replay::reset_text({reason, reader.u8()});
}

} // namespace

std::optional<Health> Client::ping()
{
    const std::optional<Bytes> body = ask_once(LINK_PING, {});
    if (!body) {
        return std::nullopt;
    }
    BodyReader reader(*body);
    const uint8_t load_pct = reader.u8();
    const uint8_t flags = reader.u8();
    Health health = {load_pct,     (flags & LINK_HEALTH_TICK_LOST) != 0,
                     who(flags),   why_lost(flags),
                     reader.u16(), reader.u32(),
                     reader.u32(), reset_of(reader)};
    const uint32_t ticket = reader.u32();
    if (!reader.is_done()) {
        refuse_answer(LINK_PING);
    }
    ticket_ = ticket;
    return health;
}

// A fault is seen before the ticket that it has made: a clear is of the one that is there now.
std::string Client::command(const drive_command_t &command)
{
    if (command.request == DRIVE_REQUEST_CLEAR) {
        (void)ping();
    }
    return verdict(LINK_COMMAND, BodyWriter()
                                     .u8(command.request)
                                     .u8(command.mode)
                                     .u32(static_cast<uint32_t>(command.target))
                                     .u32(ticket_)
                                     .body());
}

std::string Client::line(const std::string &text)
{
    return verdict(LINK_LINE, BodyWriter().u32(ticket_).text(text).body());
}

Words Client::read(uint16_t first, uint8_t words)
{
    const Bytes body = ask(patient(LINK_READ, BodyWriter().u16(first).u8(words).body()));
    BodyReader reader(body);
    const Words found = words_of(reader, LINK_READ);
    if (found.first != first || found.words.size() != words) {
        refuse_answer(LINK_READ);
    }
    return found;
}

Words Client::box(uint8_t part, uint16_t first, uint8_t words)
{
    const Bytes body = ask(patient(LINK_BOX, BodyWriter().u8(part).u16(first).u8(words).body()));
    BodyReader reader(body);
    const Words found = words_of(reader, LINK_BOX);
    if (found.first != first || found.words.size() > words) {
        refuse_answer(LINK_BOX);
    }
    return found;
}

std::vector<uint32_t> Client::read_box(uint8_t part)
{
    std::vector<uint32_t> all;
    for (bool more = true; more;) {
        const Words found = box(part, static_cast<uint16_t>(all.size()), LINK_READ_WORDS_MAX);
        all.insert(all.end(), found.words.begin(), found.words.end());
        more = found.words.size() == LINK_READ_WORDS_MAX;
    }
    return all;
}

std::string Client::write(uint16_t first, const std::vector<uint32_t> &words)
{
    BodyWriter writer;
    writer.u16(first).u8(static_cast<uint32_t>(words.size()));
    for (const uint32_t word : words) {
        writer.u32(word);
    }
    return verdict(LINK_WRITE, writer.body());
}

std::string Client::apply(uint32_t crc)
{
    return verdict(LINK_APPLY, BodyWriter().u32(crc).body());
}

std::string Client::store()
{
    return verdict(LINK_STORE);
}

std::string Client::defaults()
{
    return verdict(LINK_DEFAULTS);
}

std::string Client::stream(uint8_t entries)
{
    return verdict(LINK_STREAM, BodyWriter().u8(entries).body());
}

std::optional<Bytes> Client::ask_once(link_question_t type, const Bytes &body)
{
    try {
        return ask(quick(type, body));
    } catch (const LinkError &) {
        return std::nullopt;
    }
}

Client::Piece Client::state(uint32_t segment, uint16_t first, uint8_t words)
{
    const std::optional<Bytes> body =
        ask_once(LINK_STATE, BodyWriter().u32(segment).u16(first).u8(words).body());
    if (!body) {
        return {refused_, {}};
    }
    BodyReader reader(*body);
    const uint32_t number = reader.u32();
    const Words found = words_of(reader, LINK_STATE);
    const bool is_it = number == segment && found.first == first;
    return {true, is_it ? found : Words{}};
}

Client::Again Client::again(uint32_t segment, uint16_t first, uint8_t entries)
{
    constexpr std::size_t HEAD = 7; // segment, first entry, entries
    const std::optional<Bytes> body =
        ask_once(LINK_AGAIN, BodyWriter().u32(segment).u16(first).u8(entries).body());
    if (!body) {
        return refused_ ? Again::nothing : Again::silence;
    }
    return body->size() > HEAD ? Again::entries : Again::nothing;
}

config_block_t Client::read_block()
{
    config_block_t block{};
    for (uint32_t at = 0; at < CONFIG_BLOCK_WORDS; at += LINK_READ_WORDS_MAX) {
        const uint32_t count = std::min<uint32_t>(LINK_READ_WORDS_MAX, CONFIG_BLOCK_WORDS - at);
        const Words part = read(static_cast<uint16_t>(at), static_cast<uint8_t>(count));
        for (uint32_t k = 0; k < count; k++) {
            config_block_set_word(&block, at + k, part.words[k]);
        }
    }
    return block;
}

std::string Client::write_block(const config_block_t &block)
{
    std::string why;
    for (uint32_t at = 0; at < CONFIG_BLOCK_WORDS && why.empty(); at += LINK_READ_WORDS_MAX) {
        std::vector<uint32_t> words;
        const uint32_t end = std::min<uint32_t>(CONFIG_BLOCK_WORDS, at + LINK_READ_WORDS_MAX);
        for (uint32_t k = at; k < end; k++) {
            words.push_back(config_block_word(&block, k));
        }
        why = write(static_cast<uint16_t>(at), words);
    }
    return why.empty() ? apply(block.cfg.crc) : why;
}

} // namespace nf::live
