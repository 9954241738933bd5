// SPDX-License-Identifier: MIT
#include "readable.h"

#include <fmt/format.h>

namespace nf
{
namespace
{

unsigned byte_at(std::string_view text, std::size_t at)
{
    return static_cast<unsigned char>(text[at]);
}

// Of UTF-8, by its first byte: 0 for one that begins none.
std::size_t bytes_of(unsigned first)
{
    if (first < 0x80) {
        return 1;
    }
    if (first < 0xC2 || first > 0xF4) {
        return 0;
    }
    return first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
}

// What its first two bytes say is not too long a form, no half of a pair, and not beyond Unicode.
bool is_in_unicode(unsigned first, unsigned second)
{
    const bool too_long = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
    const bool half = first == 0xED && second >= 0xA0;
    const bool beyond = first == 0xF4 && second >= 0x90;
    return !too_long && !half && !beyond;
}

// Bytes of the first character; 0 where the text does not begin with UTF-8. The text is not empty.
std::size_t character_of(std::string_view text)
{
    const unsigned first = byte_at(text, 0);
    const std::size_t bytes = bytes_of(first);
    if (bytes < 2 || text.size() < bytes) {
        return bytes == 1 ? 1 : 0;
    }
    for (std::size_t k = 1; k < bytes; k++) {
        if ((byte_at(text, k) & 0xC0U) != 0x80U) {
            return 0;
        }
    }
    return is_in_unicode(first, byte_at(text, 1)) ? bytes : 0;
}

std::string shown_control(unsigned c)
{
    switch (c) {
    case '\n':
        return "\\n";
    case '\r':
        return "\\r";
    case '\t':
        return "\\t";
    default:
        return fmt::format("\\x{:02x}", c);
    }
}

std::string shown_character(std::string_view character)
{
    const unsigned first = byte_at(character, 0);
    if (character.size() == 1) {
        const bool prints = first >= 0x20 && first < 0x7F;
        return prints ? std::string(character) : shown_control(first);
    }
    const bool is_control =
        first == 0xC2 && byte_at(character, 1) < 0xA0; // of Latin-1's upper half
    return is_control ? fmt::format("\\u{:04x}", byte_at(character, 1)) : std::string(character);
}

} // namespace

std::string readable(std::string_view text, std::size_t most)
{
    std::string shown;
    std::size_t count = 0;
    while (!text.empty() && count < most) {
        const std::size_t bytes = character_of(text);
        shown += shown_character(text.substr(0, bytes == 0 ? 1 : bytes));
        text.remove_prefix(bytes == 0 ? 1 : bytes);
        count++;
    }
    return text.empty() ? shown : shown + "…";
}

std::string utf8_problem(std::string_view text)
{
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t bytes = character_of(text.substr(at));
        if (bytes == 0) {
            return fmt::format("\"{}\" is not UTF-8: byte {} is \\x{:02x}; allowed: UTF-8 text",
                               readable(text), at + 1, byte_at(text, at));
        }
        at += bytes;
    }
    return "";
}

} // namespace nf
