// SPDX-License-Identifier: MIT
#include "configuration_commands.h"

#include "about_text.h"
#include "answers.h"
#include "cfg_rows.h"
#include "files.h"
#include "header.h"
#include "identity.h"
#include "output_file.h"
#include "plate.h"
#include "readable.h"
#include "trimmed.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

extern "C" {
#include "config_guard.h"
}

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::live
{
namespace
{

using debug::Answer;
using debug::Outcome;

constexpr std::size_t DIFFERENCES_SHOWN = 3;

// What is compiled into an image is another, which no block carries.
bool is_of_image(const Config &before, const Config &after)
{
    return identity_of(before).board != identity_of(after).board ||
           about_name(before) != about_name(after) || before.board.baud != after.board.baud ||
           recorder_segment_entries(before.board) != recorder_segment_entries(after.board);
}

bool is_blank(char c)
{
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

bool is_of_table(char c)
{
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}

bool is_of_key(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// Whether TABLE.KEY= begins there. <regex> would add 15 kB, compressed, to the page.
bool begins_assignment(std::string::const_iterator at, std::string::const_iterator end)
{
    const auto table_end = std::find_if_not(at, end, is_of_table);
    if (table_end == at || table_end == end || *table_end != '.') {
        return false;
    }
    const auto key_end = std::find_if_not(table_end + 1, end, is_of_key);
    const auto sign = std::find_if_not(key_end, end, is_blank);
    return key_end != table_end + 1 && sign != end && *sign == '=';
}

// A value may have blanks in it; a blank before the next TABLE.KEY= ends it.
std::vector<std::string> split_assignments(const std::string &text)
{
    std::vector<std::string> parts;
    auto begin = text.begin();
    for (auto at = begin; at != text.end();) {
        const auto next = std::find_if_not(at, text.end(), is_blank);
        if (next != at && begins_assignment(next, text.end())) {
            parts.emplace_back(begin, at);
            begin = next;
        }
        at = std::find_if(next, text.end(), is_blank);
    }
    parts.emplace_back(begin, text.end());
    return parts;
}

std::string keys_of(const std::vector<std::string> &assignments)
{
    std::vector<std::string> keys;
    keys.reserve(assignments.size());
    for (const std::string &each : assignments) {
        keys.push_back(readable(debug::trimmed(each.substr(0, each.find('=')))));
    }
    return fmt::format("{}", fmt::join(keys, ", "));
}

// By the first words of a block's name, `neurofoc: MOTOR, BOARD, TUNING`.
bool is_of_another_motor(const config_block_t &block, const config_block_t &other)
{
    const auto motor_of = [](const std::string &name) { return name.substr(0, name.find(',')); };
    return motor_of(block.about.name) != motor_of(other.about.name);
}

// The board knows only its own name of a key: where one key was set, that one says more.
std::string without_path(const std::string &why)
{
    const std::string first = why.substr(0, why.find(' '));
    const auto &rows = cfg_rows();
    const bool is_path =
        std::any_of(rows.begin(), rows.end(), [&](const CfgRow &row) { return first == row.path; });
    return is_path ? why.substr(first.size() + 1) : why;
}

void put_raw(drive_cfg_t &cfg, const CfgRow &row, const drive_cfg_t &from)
{
    std::memcpy(reinterpret_cast<unsigned char *>(&cfg) + row.offset,
                reinterpret_cast<const unsigned char *>(&from) + row.offset, sizeof(uint32_t));
}

// A configuration with what is other in `after` than in `before`.
drive_cfg_t patched(const drive_cfg_t &in_force, const drive_cfg_t &before,
                    const drive_cfg_t &after)
{
    drive_cfg_t cfg = in_force;
    for (const CfgRow &row : cfg_rows()) {
        if (raw_value(row, before) == raw_value(row, after)) {
            continue;
        }
        const bool is_crc = row.offset == offsetof(drive_cfg_t, crc);
        if (!is_crc && raw_value(row, in_force) != raw_value(row, before)) {
            throw ConfigError(fmt::format(
                "{} = {} in the board is not that of the files, {}, and the change "
                "would overwrite it: give what was set with --set, or `adopt` the files",
                row.path, raw_value(row, in_force), raw_value(row, before)));
        }
        put_raw(cfg, row, after);
    }
    cfg.crc = config_guard_crc(&cfg);
    return cfg;
}

// Likewise: pole pairs, highest speed and name, which go together.
config_about_t about_of(const config_block_t &in_force, const config_block_t &before,
                        const config_block_t &after)
{
    const bool changes = std::memcmp(&before.about, &after.about, sizeof before.about) != 0;
    return changes ? after.about : in_force.about;
}

} // namespace

ConfigurationCommands::ConfigurationCommands(Follower &follower, FileChoice files)
    : follower_(follower), files_(std::move(files))
{
}

FileChoice ConfigurationCommands::files_in_force()
{
    const config_block_t block = follower_.block_in_force();
    FileChoice choice = choice_of(block.about.name, files_);
    const drive_cfg_t of_files = build(nf::live::load(choice));
    if (of_files.crc != block.cfg.crc) {
        throw ConfigError(fmt::format(
            "the configuration in force is not that of {}, {}, {}: {}. Give its own motor, board and "
            "tuning file, or `adopt` these first",
            choice.motor, choice.board, choice.tuning,
            differences(of_files, block.cfg, follower_.bases(), DIFFERENCES_SHOWN)));
    }
    return choice;
}

Answer ConfigurationCommands::set(const std::string &assignments)
{
    config_block_t block = follower_.block_in_force();
    FileChoice wanted = choice_of(block.about.name, files_);
    const Config before = nf::live::load(wanted);
    const std::vector<std::string> each = split_assignments(assignments);
    wanted.set.insert(wanted.set.end(), each.begin(), each.end());
    const Config after = nf::live::load(wanted);
    if (is_of_image(before, after)) {
        return refused(keys_of(each) + " is in the image only: build and flash");
    }
    const drive_cfg_t in_force = block.cfg;
    const config_block_t from = make_block(before);
    const config_block_t to = make_block(after);
    const drive_cfg_t cfg = patched(in_force, from.cfg, to.cfg);
    if (cfg.crc == in_force.crc) {
        return done("ok, and no number of the drive is another one");
    }
    const config_about_t about = about_of(block, from, to);
    const config_identity_t identity = block.identity;
    config_block_make(&block, &identity, &about, &cfg);
    Answer answer = apply(block);
    if (answer.outcome == Outcome::done) {
        files_ = std::move(wanted);
        answer.text = "ok: " + differences(in_force, cfg, follower_.bases(), DIFFERENCES_SHOWN);
    } else {
        answer.text = fmt::format("{}: {}", keys_of(each),
                                  each.size() == 1 ? without_path(answer.text) : answer.text);
    }
    return answer;
}

Answer ConfigurationCommands::adopt(const std::string &motor)
{
    FileChoice wanted = files_;
    wanted.motor = motor.empty() ? files_.motor : motor;
    wanted = with_own_motor(follower_.block_in_force().about.name, wanted);
    const Answer answer = apply_of_another_motor(make_block(nf::live::load(wanted)));
    if (answer.outcome == Outcome::done) {
        files_ = std::move(wanted);
    }
    return answer;
}

Config ConfigurationCommands::plate(const std::string &motor)
{
    const std::string name = follower_.block_in_force().about.name;
    FileChoice choice = files_;
    choice.motor = motor.empty() ? files_.motor : motor;
    choice = with_own_motor(name, choice);
    return known_from_plate(load_plate(choice.motor, choice.board, {}, choice.set));
}

Answer ConfigurationCommands::take_plate(const Config &plate)
{
    Config config = with_typical(plate);
    config.sources.motor_is_example =
        false; // whoever names it says that it is the one that is connected
    return apply_of_another_motor(make_block(config));
}

Answer ConfigurationCommands::apply(const config_block_t &block)
{
    return of_verdict(follower_.change(block));
}

// Whoever names a motor says that it is the one that is connected: what protects follows from it. A
// drive that runs stays locked.
Answer ConfigurationCommands::apply_of_another_motor(const config_block_t &block)
{
    (void)follower_.client().line("unlock");
    return apply(block);
}

Answer ConfigurationCommands::defaults()
{
    const Answer answer = of_verdict(follower_.defaults());
    if (answer.outcome == Outcome::done) {
        files_.set.clear();
    }
    return answer;
}

Answer ConfigurationCommands::get(const std::string &part)
{
    const drive_cfg_t cfg = follower_.block_in_force().cfg;
    const Bases bases = rescaled(follower_.bases(), cfg);
    std::string text;
    for (const CfgRow &row : cfg_rows()) {
        if (says_something(row) && std::strstr(row.path, part.c_str()) != nullptr) {
            text += fmt::format("{}{:39} {}", text.empty() ? "" : "\n", row.path,
                                value_text(row, bases, cfg));
        }
    }
    return text.empty()
               ? refused(fmt::format("no setting has \"{}\" in its path; `get` alone shows "
                                     "them all",
                                     readable(part)))
               : done(text);
}

Answer ConfigurationCommands::dump(const std::string &path)
{
    if (path.empty()) {
        return refused("dump takes the name of a file");
    }
    if (is_there(path)) {
        return refused(readable(path, READABLE_PATH) +
                       ": is there already; dump takes the name of a new file");
    }
    OutputFile file(path);
    file.write(block_bytes(follower_.block_in_force()));
    file.close();
    return done(fmt::format("ok: `nfconfig show {}`", path));
}

Answer ConfigurationCommands::load(const std::string &path)
{
    if (path.empty()) {
        return refused("load takes the file of a block, of `dump` or `nfconfig block`");
    }
    const config_block_t in_force = follower_.block_in_force();
    const config_block_t block = parse_block(path, read_bytes(path));
    Answer answer =
        is_of_another_motor(block, in_force) ? apply_of_another_motor(block) : apply(block);
    if (answer.outcome == Outcome::done) {
        files_.set.clear();
        const std::string changed =
            differences(in_force.cfg, block.cfg, follower_.bases(), DIFFERENCES_SHOWN);
        answer.text = changed.empty() ? "ok, it was in force" : "ok: " + changed;
    }
    return answer;
}

} // namespace nf::live
