/* SPDX-License-Identifier: MIT */
// The words of the firmware and the stages of a tick as a table for other debuggers.
#pragma once

#include "config.h"

#include <string>

namespace nf::debug
{

// JSON: `words`, each with home and member (drive, voltage.d), unit, format, and SI = (raw
// − zero)·one; `stages`, titles and names in the tick's order, some only while a flag is or is not
// 0; `bases`; and the `crc` of the configuration that all this is for. Throws ConfigError.
std::string table_json(const Config &config);

} // namespace nf::debug
