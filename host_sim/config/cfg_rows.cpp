// SPDX-License-Identifier: MIT
#include "cfg_rows.h"

#include <cstring>
#include <string>
#include <type_traits>
#include <unordered_map>

#include <fmt/format.h>

namespace nf
{
namespace
{

// What stands in the column `when` of cfg.def.
constexpr bool RUN = true;
constexpr bool REST = false;

std::vector<CfgRow> written_rows()
{
#define CFG(path, when, lo, hi, quantity, meaning) \
    {"cfg." #path, \
     #path, \
     offsetof(drive_cfg_t, path), \
     std::is_unsigned_v<std::remove_reference_t<decltype(drive_cfg_t{}.path)>>, \
     when, \
     Quantity::quantity, \
     meaning, \
     nullptr},
#define CFG_STARTUP CFG
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    CFG(path, when, lo, hi, quantity, meaning)
#define CFG_VOLTAGE CFG
    return {
#include "cfg.def"
        CFG(crc, RUN, , , number, "of all above, CRC-32")};
#undef CFG
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
}

} // namespace

const std::vector<CfgRow> &cfg_rows()
{
    static const std::vector<CfgRow> table = [] {
        std::vector<CfgRow> rows = written_rows();
        std::unordered_map<std::string, const CfgRow *> by_path;
        for (const CfgRow &row : rows) {
            by_path.emplace(row.path, &row);
        }
        for (CfgRow &row : rows) {
            const auto found = by_path.find(std::string(row.path) + "_shift");
            row.exponent = found == by_path.end() ? nullptr : found->second;
        }
        return rows;
    }();
    return table;
}

std::int64_t raw_value(const CfgRow &row, const drive_cfg_t &cfg)
{
    std::int32_t value = 0;
    std::memcpy(&value, reinterpret_cast<const unsigned char *>(&cfg) + row.offset, sizeof value);
    return row.is_unsigned ? static_cast<std::int64_t>(static_cast<std::uint32_t>(value)) : value;
}

Format format_of(const CfgRow &row, const Bases &bases, const drive_cfg_t &cfg)
{
    const auto exponent =
        row.exponent == nullptr ? 0U : static_cast<unsigned>(raw_value(*row.exponent, cfg));
    return format_of(row.quantity, bases, cfg, exponent);
}

std::string value_text(const CfgRow &row, const Bases &bases, const drive_cfg_t &cfg)
{
    const Format format = format_of(row, bases, cfg);
    const double value = (static_cast<double>(raw_value(row, cfg)) - format.zero) * format.one;
    return fmt::format(*format.unit == '\0' ? "{:.5g}" : "{:.5g} {}", value, format.unit);
}

} // namespace nf
