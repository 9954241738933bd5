/* SPDX-License-Identifier: MIT */
// Follows a running board: keeps the line alive, asks for what is missing, and gets into step again
// after a gap.
#pragma once

#include "client.h"
#include "shadow.h"
#include "stream.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

extern "C" {
#include "recorder_dump.h"
}

namespace nf::live
{

// Ticks that are not known: those before `from` were shown, from `until` on they are again.
struct Gap {
    int64_t from;
    int64_t until; // still open: 0
    std::string why;
};

std::string gap_text(const Gap &gap);

// What a person is to know, a line each.
struct Reporter {
    std::function<void(const std::string &)> say = [](const std::string &) {};
    std::function<void(const std::string &)> text = [](const std::string &) {}; // of the console
};

struct FollowerOptions {
    Timing timing;
    double keep_s = 10;  // for the stepper
    double ping_s = 0.2; // between two signs of life for the board, at most
    double silent_s = 1; // without a frame of it: it is asked anew who it is
};

class Follower
{
public:
    // Channel and sink outlive it.
    Follower(Channel &channel, TickSink &sink, Reporter reporter, const FollowerOptions &options);

    // Throws LinkError: no answer; or another schema, version or state, with what to do.
    void connect();

    // One pass: what has come in, one or two questions, what can be computed. Throws LinkError when
    // the board has gone.
    void step(double wait_s);

    // The stream ends, and the line is the console's again.
    void leave();

    // Writes a block, which acts from one tick on. Empty, or why not.
    std::string change(const config_block_t &block);
    // The block in force, whole and good. Throws LinkError.
    config_block_t block_in_force();
    // What acts is the board's own again.
    std::string defaults();

    Client &client()
    {
        return client_;
    }
    // Of the newest block that was read or written.
    const config_about_t &about() const
    {
        return about_;
    }
    const Bases &bases() const
    {
        return bases_;
    }
    // What the block does not say of the board, for a person: its sensor of temperature.
    void know_board(std::optional<BoardSettings> board)
    {
        board_ = std::move(board);
    }
    // NULL: not known.
    const BoardSettings *board() const
    {
        return board_ ? &*board_ : nullptr;
    }
    // What a recording of this board says of it.
    recorder_about_t recorder_about() const
    {
        return recorder_about(about_);
    }
    double kept_s() const
    {
        return options_.keep_s;
    }
    const Identity &identity() const
    {
        return identity_;
    }
    const Shadow &shadow() const
    {
        return shadow_;
    }
    const std::vector<Gap> &gaps() const
    {
        return gaps_;
    }
    // How often the board has been asked who it is: what was told before may be forgotten.
    uint64_t connections() const
    {
        return connections_;
    }
    // What the shadow has, while it is in step, is not older: the ring would have lost it.
    double oldest_s() const;
    // Why the board sends none of its ticks; empty when it does.
    const std::string &no_stream() const
    {
        return no_stream_;
    }
    double now_s() const
    {
        return client_.now_s();
    }
    uint64_t bytes_in() const
    {
        return client_.bytes_in();
    }
    // Frames that came damaged.
    uint64_t broken() const
    {
        return client_.broken();
    }
    const Health &health() const
    {
        return health_;
    }
    // How often the board's state was not that of the same inputs here.
    uint64_t departures() const
    {
        return departures_;
    }

private:
    recorder_about_t recorder_about(const config_about_t &about) const;
    void refuse_others() const;
    void learn(const config_block_t &block);
    void take_over(const config_block_t &block);
    bool know(uint32_t crc);
    void keep_alive();
    void begin_stream();
    void judge_line();
    void hear(const SegmentInfo &info);
    void tell_unshown();
    void choose_candidate();
    bool entries_hurry(const SegmentInfo &segment) const;
    bool ask_for_state();
    void begin(const SegmentInfo &info);
    bool ask_for_missing();
    void compute();
    void close_gap(int64_t tick);
    void lose(const std::string &why);

    Reporter reporter_;
    FollowerOptions options_;
    TickSink &sink_;
    Client client_;
    Identity identity_{};
    std::map<uint32_t, DriveSettings> known_; // by crc
    config_about_t about_{};
    std::optional<BoardSettings> board_;
    Bases bases_{};
    Shadow shadow_;
    std::unique_ptr<Stream> stream_;
    uint32_t at_ = 0; // segment, when in step: the next one to be computed
    std::optional<SegmentInfo> candidate_;
    double announced_s_ = 0;      // when the last segment was
    double candidate_s_ = 0;      // when the candidate was
    uint32_t tried_ = 0;          // candidates up to this one were none
    std::vector<uint32_t> state_; // of the candidate, so far
    std::vector<Gap> gaps_;
    Health health_{};
    double pinged_s_ = 0;
    double timeout_s_ = 0;     // after it a silent PC stops the motor; 0: never
    double heard_s_ = 0;       // when a frame came in last
    uint64_t heard_ = 0;       // and how many by then
    bool careful_ = false;     // the line spoils long messages
    std::string no_stream_;    // why there is none
    double shown_s_ = 0;       // when the last ticks were
    bool overwritten_ = false; // since then the ring had lost what was asked for
    double told_s_ = -std::numeric_limits<double>::infinity();
    double judged_s_ = 0;
    uint64_t judged_whole_ = 0; // by then
    uint64_t judged_broken_ = 0;
    uint64_t departures_ = 0;
    uint64_t connections_ = 0;
    uint64_t recorders_ = 0; // how often the board's recorder was seen to begin anew
};

} // namespace nf::live
