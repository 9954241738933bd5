/* SPDX-License-Identifier: MIT */
// By what an image knows the configuration blocks that it takes: config_block.h.
#pragma once

#include "configuration.h"

extern "C" {
#include "config_block.h"
}

namespace nf
{

// schema: the rows of cfg.def, each with path, offset in drive_cfg_t, sign and quantity. board: its
// name and the facts of it that are compiled into an image, those of DRIVE_ABOUT and, where there
// is a [hal], of hal_config.h. FNV-1a, 32 bits.
config_identity_t identity_of(const Config &config);

// The schema of this build.
std::uint32_t schema_hash();

} // namespace nf
