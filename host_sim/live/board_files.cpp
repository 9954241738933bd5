// SPDX-License-Identifier: MIT
#include "board_files.h"

#include "about_text.h"
#include "ends_with.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

// What is given is the only candidate.
std::vector<std::string> candidates(const std::string &given, const std::vector<std::string> &all)
{
    return given.empty() ? all : std::vector<std::string>{given};
}

// As a block has it, which cuts off what is too long.
std::string name_in_block(const Config &config)
{
    return about_name(config).substr(0, CONFIG_BLOCK_NAME_BYTES - 1);
}

// The first of the shipped files, but for those that are given, whose configuration fits.
std::optional<FileChoice> search(const FileChoice &given, const std::vector<std::string> &motors,
                                 const std::function<bool(const Config &)> &fits)
{
    FileChoice choice = given;
    for (const std::string &motor : motors) {
        choice.motor = motor;
        for (const std::string &board : candidates(given.board, list_boards())) {
            choice.board = board;
            for (const std::string &tuning : candidates(given.tuning, list_tunings())) {
                choice.tuning = tuning;
                try {
                    if (fits(load(choice))) {
                        return choice;
                    }
                } catch (const ConfigError &) {
                    continue; // files that do not go together are not those of a block
                }
            }
        }
    }
    return std::nullopt;
}

std::optional<FileChoice> search_named(const std::string &block_name, const FileChoice &given)
{
    return search(given, candidates(given.motor, list_motors()),
                  [&](const Config &config) { return name_in_block(config) == block_name; });
}

// Whether a block's name ends with these names of board and tuning file, whatever its motor is
// called.
bool ends_with_names(const std::string &block_name, const Config &config)
{
    Config nameless = config;
    nameless.motor.name.clear();
    const std::string whole = about_name(nameless);
    return debug::ends_with(block_name, whole.substr(whole.find(',')));
}

// Board and tuning of a block whose motor may be nobody's but the user's. The motor of `given`
// stays.
std::optional<FileChoice> search_around_motor(const std::string &block_name,
                                              const FileChoice &given)
{
    FileChoice any = given;
    any.set.clear();
    std::optional<FileChoice> found = search(any, list_motors(), [&](const Config &config) {
        return ends_with_names(block_name, config);
    });
    if (found) {
        found->motor = given.motor;
        found->set = given.set;
    }
    return found;
}

} // namespace

FileChoice choice_of(const std::string &block_name, const FileChoice &given)
{
    if (!given.motor.empty() && !given.board.empty() && !given.tuning.empty()) {
        return given;
    }
    if (const std::optional<FileChoice> found = search_named(block_name, given)) {
        return *found;
    }
    throw ConfigError(fmt::format("no shipped files make the board's \"{}\": give its own motor, "
                                  "board and tuning file",
                                  block_name));
}

FileChoice with_own_motor(const std::string &block_name, const FileChoice &given)
{
    if (given.motor.empty() || !(given.board.empty() || given.tuning.empty())) {
        return choice_of(block_name, given);
    }
    if (const std::optional<FileChoice> found = search_around_motor(block_name, given)) {
        return *found;
    }
    FileChoice others = given;
    others.motor.clear();
    FileChoice choice = choice_of(block_name, others);
    choice.motor = given.motor;
    return choice;
}

void check(const std::string &block_name, const FileChoice &given)
{
    if (!given.motor.empty()) {
        (void)load_motor(given.motor);
    }
    if (!given.board.empty()) {
        (void)load_board(given.board);
    }
    FileChoice files = given;
    files.set.clear();
    if (std::optional<FileChoice> found = search_named(block_name, files)) {
        found->set = given.set;
        (void)load(*found);
    } else if (!given.tuning.empty()) {
        (void)load_parts(list_motors().front(), list_boards().front(), given.tuning);
    } else {
        // files of another block, which can be read
    }
}

std::optional<BoardSettings> board_of(const std::string &block_name, const FileChoice &given)
{
    try {
        return given.board.empty() ? load(choice_of(block_name, given)).board
                                   : load_board(given.board);
    } catch (const ConfigError &) {
        return std::nullopt;
    }
}

Config load(const FileChoice &choice)
{
    return load_parts(choice.motor, choice.board, choice.tuning, {}, choice.set);
}

bool says_something(const CfgRow &row)
{
    const bool is_crc = row.offset == offsetof(drive_cfg_t, crc);
    const bool is_exponent =
        std::any_of(cfg_rows().begin(), cfg_rows().end(),
                    [&](const CfgRow &other) { return other.exponent == &row; });
    return !is_crc && !is_exponent;
}

std::string differences(const drive_cfg_t &from, const drive_cfg_t &to, const Bases &bases,
                        std::size_t most)
{
    const Bases bases_from = rescaled(bases, from);
    const Bases bases_to = rescaled(bases, to);
    std::vector<std::string> some;
    std::size_t more = 0;
    for (const CfgRow &row : cfg_rows()) {
        if (!says_something(row) || raw_value(row, from) == raw_value(row, to)) {
            continue;
        }
        if (some.size() < most) {
            some.push_back(fmt::format("{} {} to {}", row.path, value_text(row, bases_from, from),
                                       value_text(row, bases_to, to)));
        } else {
            more++;
        }
    }
    return fmt::format("{}{}", fmt::join(some, ", "),
                       more == 0 ? "" : fmt::format(", and {} more", more));
}

} // namespace nf::live
