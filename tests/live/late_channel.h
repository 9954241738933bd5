/* SPDX-License-Identifier: MIT */
// A channel whose bytes come late, as those of an adapter that collects them.
#pragma once

#include "channel.h"

#include <algorithm>
#include <deque>

class LateChannel : public nf::live::Channel
{
public:
    // The channel outlives it.
    LateChannel(nf::live::Channel &channel, double late_s) : channel_(channel), late_s_(late_s)
    {
    }

    std::vector<uint8_t> read(double wait_s) override
    {
        const double until_s = now_s() + wait_s;
        std::vector<uint8_t> bytes;
        do {
            coming_.push_back({0, channel_.read(std::min(LOOK_S, until_s - now_s()))});
            coming_.back().due_s = now_s() + late_s_;
            for (; coming_.front().due_s <= now_s(); coming_.pop_front()) {
                const std::vector<uint8_t> &come = coming_.front().bytes;
                bytes.insert(bytes.end(), come.begin(), come.end());
            }
        } while (bytes.empty() && now_s() < until_s);
        return bytes;
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        channel_.write(bytes);
    }
    double now_s() const override
    {
        return channel_.now_s();
    }

private:
    static constexpr double LOOK_S = 0.001;

    struct Coming {
        double due_s;
        std::vector<uint8_t> bytes;
    };
    nf::live::Channel &channel_;
    double late_s_;
    std::deque<Coming> coming_;
};
