// SPDX-License-Identifier: MIT
#include "log_file.h"

#include "whole_input.h"

#include <algorithm>

namespace nf
{
namespace
{

constexpr std::string_view UTF8_MARK = "\xEF\xBB\xBF";
constexpr std::string_view LOW_FIRST_MARK = "\xFF\xFE";
constexpr std::string_view HIGH_FIRST_MARK = "\xFE\xFF";
constexpr std::size_t LOOKED_AT = 256; // bytes of a log without a mark

bool starts(std::string_view bytes, std::string_view mark)
{
    return bytes.substr(0, mark.size()) == mark;
}

// Whether the high bytes of UTF-16, from `high` on, are all 0, and the low ones are not.
bool is_wide(std::string_view bytes, std::size_t high)
{
    const std::string_view part =
        bytes.substr(0, std::min(bytes.size(), LOOKED_AT) & ~std::size_t{1});
    bool wide = part.size() >= 4; // two characters tell it
    for (std::size_t k = 0; k < part.size(); k++) {
        wide = wide && (part[k] == '\0') == (k % 2 == high);
    }
    return wide;
}

std::string narrow(std::string_view bytes, std::size_t high)
{
    constexpr unsigned char ASCII_END = 0x80;
    std::string text;
    text.reserve(bytes.size() / 2);
    for (std::size_t k = 0; k + 1 < bytes.size(); k += 2) {
        const char low = bytes[k + 1 - high];
        const bool ascii = bytes[k + high] == '\0' && static_cast<unsigned char>(low) < ASCII_END;
        text += ascii ? low : '?';
    }
    return text;
}

// The first character behind the line's end at `end`.
std::size_t behind_end(std::string_view text, std::size_t end)
{
    const std::size_t behind = text.find_first_not_of('\r', end);
    const bool with_lf = behind != std::string_view::npos && text[behind] == '\n';
    return with_lf ? behind + 1 : end + 1;
}

} // namespace

std::string read_log(const std::filesystem::path &path, const std::string &keep)
{
    return read_whole(path, LOG_BYTES_MAX, keep);
}

std::string plain_text(std::string_view bytes)
{
    if (starts(bytes, UTF8_MARK)) {
        return std::string(bytes.substr(UTF8_MARK.size()));
    }
    if (starts(bytes, LOW_FIRST_MARK)) {
        return narrow(bytes.substr(LOW_FIRST_MARK.size()), 1);
    }
    if (starts(bytes, HIGH_FIRST_MARK)) {
        return narrow(bytes.substr(HIGH_FIRST_MARK.size()), 0);
    }
    for (const std::size_t high : {std::size_t{1}, std::size_t{0}}) {
        if (is_wide(bytes, high)) {
            return narrow(bytes, high);
        }
    }
    return std::string(bytes);
}

std::vector<std::string> log_lines(std::string_view bytes)
{
    const std::string plain = plain_text(bytes);
    std::vector<std::string> lines;
    for (std::string_view text = plain; !text.empty();) {
        const std::size_t end = text.find_first_of("\r\n");
        const std::string_view line = text.substr(0, end);
        lines.emplace_back(line.substr(0, line.find_last_not_of(" \t") + 1));
        text.remove_prefix(end == std::string_view::npos ? text.size() : behind_end(text, end));
    }
    return lines;
}

} // namespace nf
