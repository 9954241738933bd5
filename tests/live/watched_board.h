/* SPDX-License-Identifier: MIT */
// A simulated board whose every tick is kept, and what a follower of it has shown.
#pragma once

#include "follower.h"
#include "simulated_board.h"

#include <cstdint>
#include <string>
#include <vector>

extern "C" {
#include "drive_words.h"
#include "testing.h"
}

// What the board's control interrupt has done.
class BoardLog : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        frames.push_back(tick.sim->in());
        outputs.push_back(tick.sim->out());
        hashes.push_back(drive_words_hash(&tick.sim->drive()));
        states.push_back(tick.sim->drive().state);
    }

    std::vector<drive_in_t> frames;
    std::vector<drive_out_t> outputs;
    std::vector<uint32_t> hashes; // of the state behind each tick
    std::vector<drive_state_t> states;
};

// What was shown of it, compared with it.
class ShownTicks : public nf::TickSink
{
public:
    explicit ShownTicks(const BoardLog &board) : board_(board)
    {
    }

    void add(const nf::Tick &tick) override
    {
        const drive_t &drive = tick.sim->drive();
        const std::size_t at = drive.tick - 1U;
        TEST_ASSERT_LESS_THAN_MESSAGE(board_.hashes.size(), at,
                                      "a tick that the board has not had");
        wrong += drive_words_hash(&drive) == board_.hashes[at] ? 0U : 1U;
        jumps += !ticks.empty() && at != ticks.back() + 1 ? 1U : 0U;
        ticks.push_back(at);
    }

    std::vector<std::size_t> ticks;
    uint64_t wrong = 0;
    uint64_t jumps = 0;

private:
    const BoardLog &board_;
};
