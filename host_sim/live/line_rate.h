/* SPDX-License-Identifier: MIT */
// What the stream needs of a line.
#pragma once

#include <cstdint>

namespace nf::live
{

constexpr double BITS_OF_A_BYTE = 10; // with start and stop bit

// Bytes of the stream for a tick, with all that is around it: the largest mean over 0.1 s of S1 to
// S5, which is S3 with a sensor of the angle (docs/live.md).
constexpr double BYTES_OF_A_TICK = 3.5;

// So much of the line may be the stream: the rest is for questions, answers, and what has to be
// sent again.
constexpr double SHARE_OF_THE_STREAM = 0.9;

inline double baud_needed(double ticks_per_s)
{
    return ticks_per_s * BYTES_OF_A_TICK * BITS_OF_A_BYTE / SHARE_OF_THE_STREAM;
}

} // namespace nf::live
