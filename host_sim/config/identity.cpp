// SPDX-License-Identifier: MIT
#include "identity.h"

#include "about_text.h"
#include "hal_header.h"

#include <cstddef>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr std::uint32_t FNV_BASIS = 2166136261U;
constexpr std::uint32_t FNV_PRIME = 16777619U;

// The text and its end.
constexpr std::uint32_t mix(std::uint32_t hash, std::string_view text)
{
    for (const char c : text) {
        hash = (hash ^ static_cast<unsigned char>(c)) * FNV_PRIME;
    }
    return hash * FNV_PRIME;
}

constexpr std::uint32_t mix(std::uint32_t hash, std::size_t number)
{
    for (unsigned k = 0; k < 32; k += 8) {
        hash = (hash ^ static_cast<std::uint32_t>(number >> k & 0xFF)) * FNV_PRIME;
    }
    return hash;
}

constexpr std::uint32_t make_schema_hash()
{
    std::uint32_t hash = mix(FNV_BASIS, sizeof(drive_cfg_t));
#define CFG(path, when, lo, hi, quantity, meaning) \
    hash = \
        mix(mix(mix(mix(hash, #path), offsetof(drive_cfg_t, path)), \
                std::size_t{ \
                    std::is_unsigned_v<std::remove_reference_t<decltype(drive_cfg_t{}.path)>>}), \
            #quantity);
#define CFG_STARTUP CFG
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    CFG(path, when, lo, hi, quantity, meaning)
#define CFG_VOLTAGE CFG
#include "cfg.def"
#undef CFG
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
    return hash;
}

} // namespace

std::uint32_t schema_hash()
{
    constexpr std::uint32_t hash = make_schema_hash();
    return hash;
}

config_identity_t identity_of(const Config &config)
{
    const std::string facts = fmt::format("{}\n{}\n{}{}", config.board.name, tick_ps(config.board),
                                          about_board(config.board), hal_facts(config));
    return {schema_hash(), mix(FNV_BASIS, facts)};
}

} // namespace nf
