/* SPDX-License-Identifier: MIT */
// The lines that a board's console says while the drive measures its motor.
#pragma once

#include <string>
#include <vector>

namespace nf::live
{

class Measurement
{
public:
    // A line of the console. Returns whether it is one of the numbers of the measurement, which
    // nobody needs to see.
    bool take(const std::string &line);

    // It is stopped: the board says no more of it.
    void stop();

    // It is over, or was never begun.
    bool has_ended() const
    {
        return ended_;
    }
    // Why it has not come to its end, in the board's words; empty: it has, or it goes on.
    const std::string &refusal() const
    {
        return refusal_;
    }
    // For identify::read_records().
    const std::vector<std::string> &lines() const
    {
        return lines_;
    }
    // What the board has said that it does, in its order; the last one is what it does now.
    const std::vector<std::string> &phases() const
    {
        return phases_;
    }

private:
    std::vector<std::string> lines_;
    std::vector<std::string> phases_;
    bool ended_ = false;
    std::string refusal_;
};

} // namespace nf::live
