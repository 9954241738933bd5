/* SPDX-License-Identifier: MIT */
// A recording out of whatever a serial line was logged with.
#pragma once

#include "recording.h"

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace nf::replay
{

// The last recording in it that is whole; text of a console may be before, behind and in between, and what a logger puts in
// front of each line, and blanks behind. Throws RecordingError
// with what is wrong with the last one when none is, and nothing else, for whatever the bytes are.
Recording read(std::string_view bytes);

constexpr std::size_t FILE_BYTES_MAX = std::size_t{64} << 20U;

// Of a file of at most so many bytes, which may be a pipe. The message begins with its path.
Recording read_file(const std::filesystem::path &path);

} // namespace nf::replay
