/* SPDX-License-Identifier: MIT */
// The firmware's integers beside what they mean in SI units.
#pragma once

#include "config.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace nf
{

// One field of drive_cfg_t.
struct ConfigRow {
    std::string path; // "current_loop.pi_d.kp"
    std::int64_t value;
    bool is_unsigned;
    std::size_t bytes;
    bool in_run;         // may change while current flows
    std::string meaning; // "T·R/L_d = 0.0183"
};

// Every field of drive_cfg_t in the order of its declaration.
std::vector<ConfigRow> describe(const Config &config, const drive_cfg_t &built);

} // namespace nf
