/* SPDX-License-Identifier: MIT */
// The C header that gives a target its configuration.
#pragma once

#include "config.h"

#include <cstdint>
#include <string>

namespace nf
{

// Entries of one segment of the flight recorder: board.recorder_entries shared out,
// RECORDER_ENTRIES_MIN at least.
uint32_t recorder_segment_entries(const BoardSettings &board);

// The whole header: `static const drive_cfg_t DRIVE_CONFIG`, its provenance and the SI meaning of
// each field; DRIVE_ABOUT, for about_t of firmware/app; and the recorder's size. The same files
// give the same text on every machine.
std::string make_header(const Config &config);

} // namespace nf
