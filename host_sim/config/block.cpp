// SPDX-License-Identifier: MIT
#include "block.h"

#include "about_text.h"
#include "cfg_rows.h"
#include "hal_header.h"
#include "identity.h"
#include "origin.h"

#include <cstring>

#include <fmt/format.h>

namespace nf
{
namespace
{

// What is compared, and whether its numbers are read as bits.
struct Wrong {
    const char *what;
    const char *numbers;
};

Wrong wrong(config_block_fault_t fault)
{
    static const char *const BITS = "found 0x{:08X}, expected 0x{:08X}";
    static const char *const COUNT = "found {}, expected {}";
    switch (fault) {
    case CONFIG_BLOCK_NO_BLOCK:
        return {"this is no configuration block, the magic word", BITS};
    case CONFIG_BLOCK_OTHER_VERSION:
        return {"the version of its layout", COUNT};
    case CONFIG_BLOCK_OTHER_LENGTH:
        return {"the length that it says it has in words", COUNT};
    case CONFIG_BLOCK_BROKEN:
        return {"the block is damaged, its CRC", BITS};
    case CONFIG_BLOCK_OTHER_SCHEMA:
        return {"it is for a firmware with other settings, the schema", BITS};
    default:
        return {"it is for another board, the board", BITS};
    }
}

[[noreturn]] void refuse_block(const std::string &name, const std::string &problem)
{
    throw ConfigError(name + ": " + problem);
}

// Of a block whose setting is wrong.
std::string value_of(const config_block_t &block, const std::string &setting)
{
    for (const CfgRow &row : cfg_rows()) {
        if (setting == row.path) {
            return fmt::format(" = {}", raw_value(row, block.cfg));
        }
    }
    return "";
}

} // namespace

config_block_t make_block(const Config &config)
{
    if (!hal_facts(config).empty()) {
        (void)make_hal_header(config);
    }
    config_about_t about = {};
    about.pole_pairs = static_cast<std::uint32_t>(config.motor.pole_pairs);
    about.speed_max_rpm = speed_max_rpm(config.motor);
    about.is_example = config.sources.motor_is_example ? 1 : 0;
    config_block_name(about.name, about_name(config).c_str());
    const config_identity_t identity = identity_of(config);
    const drive_cfg_t cfg = build(config);
    config_block_t block = {};
    config_block_make(&block, &identity, &about, &cfg);
    return block;
}

std::string block_bytes(const config_block_t &block)
{
    std::string bytes(CONFIG_BLOCK_BYTES, '\0');
    config_block_encode(&block, reinterpret_cast<std::uint8_t *>(bytes.data()));
    return bytes;
}

config_block_t parse_block(const std::string &name, const std::string &bytes)
{
    if (bytes.size() != CONFIG_BLOCK_BYTES) {
        refuse_block(name, fmt::format("the file's length: found {} bytes, expected {}",
                                       bytes.size(), CONFIG_BLOCK_BYTES));
    }
    config_block_t block = {};
    config_block_decode(&block, reinterpret_cast<const std::uint8_t *>(bytes.data()));
    const config_identity_t expected = {schema_hash(), block.identity.board};
    const config_block_verdict_t verdict = config_block_check(&block, &expected);
    if (verdict.setting != nullptr) {
        refuse_block(name, fmt::format("{}{}: the firmware does not take this value",
                                       verdict.setting, value_of(block, verdict.setting)));
    }
    if (verdict.fault != CONFIG_BLOCK_GOOD) {
        const Wrong is = wrong(verdict.fault);
        refuse_block(name,
                     fmt::format("{}: ", is.what) +
                         fmt::format(fmt::runtime(is.numbers), verdict.found, verdict.expected));
    }
    return block;
}

std::string describe_block(const config_block_t &block)
{
    std::string text = fmt::format("{:39}{}\n", "name", block.about.name);
    const auto add = [&](const char *name, const std::string &value) {
        text += fmt::format("{:39}{:>12}\n", name, value);
    };
    add("schema", fmt::format("0x{:08X}", block.identity.schema));
    add("board", fmt::format("0x{:08X}", block.identity.board));
    add("about.pole_pairs", std::to_string(block.about.pole_pairs));
    add("about.speed_max_rpm", std::to_string(block.about.speed_max_rpm));
    add("about.is_example", std::to_string(block.about.is_example));
    for (const CfgRow &row : cfg_rows()) {
        add(row.path, std::to_string(raw_value(row, block.cfg)));
    }
    return text;
}

} // namespace nf
