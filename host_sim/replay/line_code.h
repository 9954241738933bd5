/* SPDX-License-Identifier: MIT */
// The lines that a recording is sent in: see firmware/record/recorder_dump.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

extern "C" {
#include "recorder_dump.h"
}

namespace nf::replay
{

struct Line {
    uint32_t number;
    std::array<uint32_t, RECORDER_LINE_WORDS> words;

    bool operator==(const Line &other) const
    {
        return number == other.number && words == other.words;
    }
    bool operator!=(const Line &other) const
    {
        return !(*this == other);
    }
};

// Of a line with its mark, without its end. Throws RecordingError.
Line decode_line(std::string_view text);

// As the firmware computes it.
uint32_t crc_of(const uint32_t *words, std::size_t count);

} // namespace nf::replay
