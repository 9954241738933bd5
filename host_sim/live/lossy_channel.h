/* SPDX-License-Identifier: MIT */
// A bad line: it changes, drops and doubles bytes, by chance but always the same for a seed.
#pragma once

#include "channel.h"

#include <random>
#include <vector>

namespace nf::live
{

// Probabilities of a byte, each 0…1; together at most 1.
struct Loss {
    double changed = 0; // to any other value
    double dropped = 0;
    double doubled = 0;
};

class LossyChannel : public Channel
{
public:
    // The channel outlives it.
    LossyChannel(Channel &channel, const Loss &to_board, const Loss &from_board, uint32_t seed)
        : channel_(channel), to_board_(to_board), from_board_(from_board), random_(seed)
    {
    }

    std::vector<uint8_t> read(double wait_s) override
    {
        return spoilt(channel_.read(wait_s), from_board_);
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        channel_.write(spoilt(bytes, to_board_));
    }
    double now_s() const override
    {
        return channel_.now_s();
    }

    // Bytes that did not come through as they were.
    uint64_t spoilt_bytes() const
    {
        return spoilt_bytes_;
    }

private:
    std::vector<uint8_t> spoilt(const std::vector<uint8_t> &bytes, const Loss &loss);

    Channel &channel_;
    Loss to_board_;
    Loss from_board_;
    std::mt19937 random_;
    uint64_t spoilt_bytes_ = 0;
};

} // namespace nf::live
