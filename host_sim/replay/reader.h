/* SPDX-License-Identifier: MIT */
// A recording out of whatever a serial line was logged with.
#pragma once

#include "recording.h"

#include <filesystem>
#include <string_view>

namespace nf::replay
{

// The last recording in a log (log_file.h) that is whole; text of a console may be before, behind
// and in between, and what a logger puts in front of each line. Throws RecordingError with what is
// wrong with the last one when none is, and nothing else, for whatever the bytes are.
Recording read(std::string_view bytes);

// Of a file, as read_log() takes it. The message begins with its path.
Recording read_file(const std::filesystem::path &path);

} // namespace nf::replay
