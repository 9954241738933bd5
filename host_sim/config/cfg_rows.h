/* SPDX-License-Identifier: MIT */
// The rows of cfg.def as a table: whoever shows, asks or writes settings of the firmware by name
// goes through it.
#pragma once

#include "quantity.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace nf
{

struct CfgRow {
    const char *signal; // its name among the signals: "cfg.current_loop.pi_d.kp"
    const char *path;   // "current_loop.pi_d.kp"
    std::size_t offset; // in drive_cfg_t, 32 bits
    bool is_unsigned;
    bool in_run; // may change while current flows, else only at rest
    Quantity quantity;
    const char *meaning;    // {} is the value with its unit
    const CfgRow *exponent; // of a mantissa, else NULL
};

// In the order of cfg.def; crc is the last.
const std::vector<CfgRow> &cfg_rows();

std::int64_t raw_value(const CfgRow &row, const drive_cfg_t &cfg);

// What one of it is.
Format format_of(const CfgRow &row, const Bases &bases, const drive_cfg_t &cfg);

// Its value with unit: "0.0183", "12.5 A".
std::string value_text(const CfgRow &row, const Bases &bases, const drive_cfg_t &cfg);

} // namespace nf
