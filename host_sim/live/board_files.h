/* SPDX-License-Identifier: MIT */
// The motor, board and tuning files of a running drive: what its numbers were made of, and what a
// person sets in them.
#pragma once

#include "block.h"
#include "cfg_rows.h"
#include "config.h"

#include <optional>
#include <string>
#include <vector>

namespace nf::live
{

// By name or path; empty: the shipped file that the board's name says.
struct FileChoice {
    std::string motor;
    std::string board;
    std::string tuning;
    std::vector<std::string> set; // KEY=VALUE, each over those before
};

// Fills in what is empty from the name of a block, `neurofoc: MOTOR, BOARD, TUNING`. Throws
// ConfigError when no shipped files have these names.
FileChoice choice_of(const std::string &block_name, const FileChoice &given);

// The same where the motor is not that of the block, which may be no shipped one: its board and
// tuning are.
FileChoice with_own_motor(const std::string &block_name, const FileChoice &given);

// Whether what is given can be read, and its keys be set, for a block of this name. Throws
// ConfigError. That the names do not go with the block is no reason: the files may be adopted.
void check(const std::string &block_name, const FileChoice &given);

// The board of a block of this name: the file that is given, or the shipped one. None where no file
// can be found.
std::optional<BoardSettings> board_of(const std::string &block_name, const FileChoice &given);

// Throws ConfigError.
Config load(const FileChoice &choice);

// The CRC, and the exponent of another row's value, say nothing to a person.
bool says_something(const CfgRow &row);

// The settings of the drive that differ, "observer.eta 569.75 to 449.81", and how many more there
// are than `most`. `bases`: of the motor and board of both.
std::string differences(const drive_cfg_t &from, const drive_cfg_t &to, const Bases &bases,
                        std::size_t most);

} // namespace nf::live
