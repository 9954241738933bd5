/* SPDX-License-Identifier: MIT */
// The channel of a board whose time goes slower or faster than this machine's, as in an emulator:
// all waits are the board's.
#pragma once

#include "channel.h"

namespace nf::live
{

class PacedChannel : public Channel
{
public:
    // `pace`: seconds of the board in a second, above 0. The channel outlives it.
    PacedChannel(Channel &channel, double pace) : channel_(channel), pace_(pace)
    {
    }

    std::vector<uint8_t> read(double wait_s) override
    {
        return channel_.read(wait_s / pace_);
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        channel_.write(bytes);
    }
    double now_s() const override
    {
        return channel_.now_s() * pace_;
    }

private:
    Channel &channel_;
    double pace_;
};

} // namespace nf::live
