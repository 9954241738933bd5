// SPDX-License-Identifier: MIT
#include "line_code.h"

#include "recording.h"

extern "C" {
#include "crc32.h"
}

#include <cstring>

#include <fmt/format.h>

namespace nf::replay
{
namespace
{

constexpr std::size_t LINE_WORDS = RECORDER_LINE_WORDS + 2; // with number and CRC
constexpr std::size_t LINE_BYTES = LINE_WORDS * sizeof(uint32_t);
constexpr std::size_t DIGITS_AT_ONCE = 4; // of three bytes
constexpr std::size_t BYTES_AT_ONCE = 3;

uint32_t digit(char c)
{
    constexpr std::string_view DIGITS =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t at = DIGITS.find(c);
    if (at == std::string_view::npos) {
        throw RecordingError(fmt::format("0x{:02x} is no digit of base64: it is damaged",
                                         static_cast<unsigned char>(c)));
    }
    return static_cast<uint32_t>(at);
}

} // namespace

uint32_t crc_of(const uint32_t *words, std::size_t count)
{
    uint32_t crc = CRC32_START;
    for (std::size_t k = 0; k < count; k++) {
        std::array<uint8_t, sizeof(uint32_t)> bytes{};
        std::memcpy(bytes.data(), words + k, bytes.size());
        crc = crc32_step(crc, bytes.data());
    }
    return ~crc;
}

Line decode_line(std::string_view text)
{
    if (text.size() != RECORDER_LINE_CHARACTERS) {
        throw RecordingError(fmt::format("it has {} characters, a line of a recording {}",
                                         text.size(), RECORDER_LINE_CHARACTERS));
    }
    std::array<uint8_t, LINE_BYTES> bytes{};
    for (std::size_t k = 0; k < LINE_BYTES / BYTES_AT_ONCE; k++) {
        uint32_t group = 0;
        for (std::size_t d = 0; d < DIGITS_AT_ONCE; d++) {
            group = group << 6U | digit(text[1 + DIGITS_AT_ONCE * k + d]);
        }
        for (std::size_t b = 0; b < BYTES_AT_ONCE; b++) {
            bytes.at(BYTES_AT_ONCE * k + b) = static_cast<uint8_t>(group >> (16 - 8 * b) & 0xFFU);
        }
    }
    std::array<uint32_t, LINE_WORDS> words{};
    std::memcpy(words.data(), bytes.data(), bytes.size());
    const uint32_t crc = crc_of(words.data(), LINE_WORDS - 1);
    if (crc != words.back()) {
        throw RecordingError(fmt::format("its CRC is 0x{:08x}, its bytes make 0x{:08x}: it is "
                                         "damaged",
                                         words.back(), crc));
    }
    Line line{words[0], {}};
    std::memcpy(line.words.data(), words.data() + 1, sizeof line.words);
    return line;
}

} // namespace nf::replay
