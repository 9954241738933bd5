/* SPDX-License-Identifier: MIT */
// The configuration block (config_block.h) of motor, board and tuning, and what a file holds that
// should be one.
#pragma once

#include "config.h"

extern "C" {
#include "config_block.h"
}

#include <filesystem>
#include <string>

namespace nf
{

// The block. Refuses what the board's image cannot do: where there is a [hal], as make_hal_header()
// does.
config_block_t make_block(const Config &config);

// Its bytes, as a file has them.
std::string block_bytes(const config_block_t &block);

// The block of a file. Throws ConfigError with one line, what is wrong with what was found and what
// was expected, when the bytes are no block that this program's firmware takes on the board that
// they name.
config_block_t parse_block(const std::string &name, const std::string &bytes);

// What it holds: the words before the configuration, then each setting by its path.
std::string describe_block(const config_block_t &block);

} // namespace nf
