/* SPDX-License-Identifier: MIT */
// The PC's side of the link: one question at a time, asked again until its answer comes.
#pragma once

#include "channel.h"
#include "frames.h"

#include <array>
#include <bitset>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

extern "C" {
#include "config_block.h"
#include "io.h"
#include "recorder.h"
}

namespace nf::live
{

// No answer, one that the link does not know, or the board does not know the question. In one line.
struct LinkError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Timing {
    double answer_s = 0.05; // until a question is asked again
    unsigned tries = 40;
    double ring_s = 0.02; // the same for one that is asked once: what the ring may lose meanwhile;
                          // longer where answers come late
};

struct Identity {
    uint8_t version;
    uint8_t capabilities; // LINK_CAN_…
    uint16_t state_words;
    uint16_t block_words;
    uint16_t segment_entries;
    config_identity_t config;
    uint32_t tick_ps;
    uint32_t baud;
    uint32_t current_full_scale_ua;
    uint32_t bus_full_scale_uv;
    std::array<uint8_t, 20> build;
};

struct Health {
    uint8_t load_pct;
    bool tick_lost;
    std::string source;     // who commands the drive, as its console says it
    std::string input_lost; // why the input is lost; "": it is there, or there is none
    uint16_t adc_ic;
    uint32_t late_ticks;
    uint32_t frames_lost;
    std::string reset; // why the chip has started, for a person
};

// LINK_SEGMENT.
struct SegmentInfo {
    uint32_t number;
    uint32_t first_tick;
    uint32_t hash; // of the state before it
    uint32_t config_crc;
    uint16_t entries_before; // of the segment before it; 0: the board does not know
    bool follows;
};

// LINK_FRAMES, decoded.
struct Entries {
    uint32_t segment;
    uint16_t first;
    std::vector<recorder_entry_t> entries;
};

// Words of a block or of a state, from `first` on.
struct Words {
    uint16_t first;
    std::vector<uint32_t> words;
};

// What the board says unasked.
struct Listener {
    std::function<void(const std::string &)> text = [](const std::string &) {};
    std::function<void(const SegmentInfo &)> segment = [](const SegmentInfo &) {};
    std::function<void(const Entries &)> entries = [](const Entries &) {};
};

class Client
{
public:
    // The channel outlives it.
    Client(Channel &channel, const Timing &timing, Listener listener);

    // Takes what comes in; waits up to `wait_s` for a first byte. Throws ChannelError, as all
    // below.
    void poll(double wait_s);

    // All throw LinkError. A verdict is why not, empty when it is done. command() and line() carry
    // the ticket of the last answer, see commander.h: what the board has done or met since then
    // makes it refuse them.
    Identity hello();
    void bye();
    // Asked once: nothing when no answer comes.
    std::optional<Health> ping();
    std::string command(const drive_command_t &command);
    std::string line(const std::string &text);
    // Of the block in force.
    Words read(uint16_t first, uint8_t words);
    // Of the black box, LINK_BOX_…, as far as there are words.
    Words box(uint8_t part, uint16_t first, uint8_t words);
    // All of them.
    std::vector<uint32_t> read_box(uint8_t part);
    std::string write(uint16_t first, const std::vector<uint32_t> &words);
    std::string apply(uint32_t crc);
    std::string store();
    std::string defaults();
    // entries: of a message, at most; 0 ends the stream.
    std::string stream(uint8_t entries);

    // Of something that the ring may have lost, asked once: whoever asks decides what next.
    struct Piece {
        bool answered; // and nothing in it: the board has not got it
        Words words;
    };
    Piece state(uint32_t segment, uint16_t first, uint8_t words);
    // What comes goes to the listener.
    enum class Again {
        silence, // no answer
        nothing, // an answer without entries: the board has not got them
        entries
    };
    Again again(uint32_t segment, uint16_t first, uint8_t entries);

    // The whole block in force, whatever its parts were read from: its CRC says whether they are of
    // one.
    config_block_t read_block();
    // The whole block, prepared and applied.
    std::string write_block(const config_block_t &block);

    // The rate of the line: the answer to a question that is asked once is waited for as long as it
    // may take, behind a message that is on its way.
    void has_rate(uint32_t baud);

    double now_s() const
    {
        return channel_.now_s();
    }
    uint64_t bytes_in() const
    {
        return bytes_in_;
    }
    // Frames that came in.
    uint64_t whole() const
    {
        return reader_.whole();
    }
    uint64_t broken() const
    {
        return reader_.broken();
    }
    uint64_t repeats() const
    {
        return repeats_;
    }

private:
    struct Question {
        link_question_t type;
        Bytes body;
        double answer_s;
        unsigned tries;
        bool impatient; // a damaged frame may have been the answer: it is not waited for any more
    };
    Question patient(link_question_t type, const Bytes &body = {}) const
    {
        return {type, body, timing_.answer_s, timing_.tries, false};
    }
    Question quick(link_question_t type, const Bytes &body) const
    {
        return {type, body, timing_.ring_s, 1, true};
    }
    Bytes ask(const Question &question);
    // The answer of a question that is asked once; nothing: none came, or it is refused, see
    // refused_.
    std::optional<Bytes> ask_once(link_question_t type, const Bytes &body);
    std::string verdict(link_question_t type, const Bytes &body = {});
    void wait_for_answer(const Question &question);
    void take(const Message &message);
    void notice_late(const Message &message);
    void take_segment(const Bytes &body);
    void take_frames(const Bytes &body);

    Channel &channel_;
    Timing timing_;
    Listener listener_;
    FrameReader reader_;
    uint64_t bytes_in_ = 0;
    uint64_t repeats_ = 0;
    Message awaited_{}; // type and tag of the answer, and its body once it is there
    bool answered_ = false;
    bool refused_ = false;
    std::bitset<256> given_up_; // tags whose answer is not waited for any more
    uint32_t ticket_ = 0;       // of the next command
};

} // namespace nf::live
