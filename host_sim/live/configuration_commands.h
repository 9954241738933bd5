/* SPDX-License-Identifier: MIT */
// What a person tells a running board about its configuration: keys of files, blocks of files, the
// one that is stored.
#pragma once

#include "board_files.h"
#include "commands.h"
#include "follower.h"

#include <string>

namespace nf::live
{

// All throw ConfigError, OutputError and LinkError, each in one line.
class ConfigurationCommands
{
public:
    // The follower is connected and outlives it.
    ConfigurationCommands(Follower &follower, FileChoice files);

    // One or several KEY=VALUE, which act together from one tick on. Only settings of the drive
    // that these keys change are written; a setting that somebody has changed without the files is
    // not changed again, and its path is said.
    debug::Answer set(const std::string &assignments);
    // That of the files; with a motor's, which is the session's from then on. At rest what protects
    // is unlocked for it.
    debug::Answer adopt(const std::string &motor = "");
    // The name plate of a file on the board that is connected, or, without one, of the motor in
    // force.
    Config plate(const std::string &motor);
    // A name plate becomes what is in force, with typical values (plate.h) for what it does not
    // say. Unlocks as adopt().
    debug::Answer take_plate(const Config &plate);
    // That of the image.
    debug::Answer defaults();
    // The settings in force whose paths have this text in them, a line each; all when it is empty.
    debug::Answer get(const std::string &part);
    // The block in force as a file that is not there yet.
    debug::Answer dump(const std::string &path);
    // The block of a file. One for another motor unlocks as adopt().
    debug::Answer load(const std::string &path);

    // The files, and what was set in them, that make the configuration in force. Refused where they
    // make another one.
    FileChoice files_in_force();

private:
    debug::Answer apply(const config_block_t &block);
    debug::Answer apply_of_another_motor(const config_block_t &block);

    Follower &follower_;
    FileChoice files_;
};

} // namespace nf::live
