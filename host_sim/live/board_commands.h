/* SPDX-License-Identifier: MIT */
// What a person or a script tells a running board, a line each.
#pragma once

#include "commands.h"
#include "configuration_commands.h"
#include "follower.h"
#include "identification.h"
#include "output_file.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace nf::live
{

// What a line needs of whoever reads the lines.
struct Surroundings {
    std::function<void(const std::string &)> say;     // a line
    std::function<void(double)> pass;                 // follow the board for so long
    std::function<bool(const RecordedRun &)> stepper; // false: a command there was refused
};

class BoardCommands
{
public:
    // The follower is connected and outlives it.
    BoardCommands(Follower &follower, const FileChoice &files, Surroundings surroundings);

    // What the console says in frames, whatever pieces they are.
    void take_text(const std::string &characters);

    // A line. A command that the board does not answer is refused with that reason.
    debug::Answer execute(const std::string &line);

    static std::string help();

    // The name plate of a file on the board that is connected, or, without one, of the motor in
    // force. Throws ConfigError and LinkError.
    Config plate(const std::string &file);

    // The drive begins to measure the motor of a name plate, which becomes the configuration in
    // force; without a file that in force. It goes on while the board is followed. Throws as
    // plate().
    debug::Answer begin_identification(const std::string &file);
    // The one that is under way, or has ended and was not taken; NULL: none.
    const Identification *identification() const
    {
        return identification_ ? &*identification_ : nullptr;
    }
    bool identification_has_ended() const;
    // Of the one that has ended, or is given up. Throws ConfigError: why nothing was found.
    MeasuredMotor take_identification();

    // The files, and what was set in them, that make the configuration in force. Throws ConfigError
    // where they make another one, and LinkError.
    FileChoice files_in_force();

    // That of the motor's largest current, by the configuration in force, N·m. LinkError.
    double torque_max_nm();

    // What the drive is told, without a request to clear; nothing where that is not known. Of a
    // measurement only the request counts.
    std::optional<drive_command_t> in_force() const;

    // The drive is asked to run, as far as that is known.
    bool runs() const
    {
        const std::optional<drive_command_t> now = in_force();
        return now && (now->request & DRIVE_REQUEST_RUN) != 0;
    }

private:
    debug::Answer command(const drive_command_t &command);
    debug::Answer amend(const std::function<void(drive_command_t &)> &change);
    debug::Answer request(uint8_t what);
    debug::Answer stop();
    debug::Answer run();
    debug::Answer identify(const std::string &files);
    debug::Answer identify(const std::string &plate, OutputFile *file);
    bool measures() const;
    debug::Answer speed(const std::string &value);
    debug::Answer zero();
    debug::Answer position(const std::string &value);
    debug::Answer torque(const std::string &value);
    debug::Answer store();
    debug::Answer record(const std::string &path);
    debug::Answer record_ring(OutputFile &file);
    debug::Answer record_shown(const RecordedRun &run, OutputFile &file);
    debug::Answer last(const std::string &path);
    debug::Answer wait(const std::string &seconds);
    debug::Answer step_through(const std::string &seconds);
    debug::Answer status() const;
    void remember(const std::optional<drive_command_t> &command);
    void take_line(const std::string &line);
    bool dump_once();

    Follower &follower_;
    ConfigurationCommands configuration_;
    Surroundings surroundings_;
    std::optional<drive_command_t>
        commanded_; // last, by this session; none: only a part of it is known
    double commanded_s_ = 0;
    uint64_t commanded_in_ = 0; // connection; 0: none
    std::string line_;          // of the console, so far
    std::optional<Identification> identification_;
    uint64_t identifies_in_ = 0; // connection
    bool dumping_ = false;
    std::string dump_;
    bool dump_ended_ = false;
};

// "RUN, speed 1500 of 1500 rpm, i_q 1.2 A, bus 24.0 V, load 42 %": what is verified, and what the
// board says of itself.
std::string status_text(const Follower &follower);

} // namespace nf::live
