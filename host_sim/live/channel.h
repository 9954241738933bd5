/* SPDX-License-Identifier: MIT */
// Bytes to a board and from it: a serial port, a pseudo-terminal, or a simulated board in the same
// program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace nf::live
{

// The line is gone, in one line for a person.
struct ChannelError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class Channel
{
public:
    virtual ~Channel() = default;

    // What has come in since the last call; waits up to `wait_s` for a first byte. Empty when none
    // came. Throws ChannelError.
    virtual std::vector<uint8_t> read(double wait_s) = 0;

    // Takes all of it. Throws ChannelError.
    virtual void write(const std::vector<uint8_t> &bytes) = 0;

    // Seconds of a clock that only goes forwards; that of the simulated board where there is one.
    virtual double now_s() const = 0;
};

} // namespace nf::live
