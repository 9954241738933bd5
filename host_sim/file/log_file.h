/* SPDX-License-Identifier: MIT */
// A log that a terminal program has written, as lines of plain text. What the program adds does not
// matter: a byte order mark, UTF-16 in place of bytes, and any end of a line. What it puts in front
// of a line is the caller's to skip.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nf
{

constexpr std::size_t LOG_BYTES_MAX = std::size_t{64} << 20U;

// The bytes of a file of at most LOG_BYTES_MAX, which may be a pipe. Throws InputError where it
// cannot be read or is longer; `keep` says what to keep of one that is.
std::string read_log(const std::filesystem::path &path, const std::string &keep);

// Without the mark at its beginning. UTF-16 is known by its mark, or where every second byte is 0;
// a character of it that is not ASCII becomes '?'.
std::string plain_text(std::string_view bytes);

// The lines of plain_text(bytes) without their ends, which are LF, CR, or CRs and LF, and without
// blanks behind. The first one is line 1 for the user.
std::vector<std::string> log_lines(std::string_view bytes);

} // namespace nf
