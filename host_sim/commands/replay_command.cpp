// SPDX-License-Identifier: MIT
#include "replay_command.h"

#include "conversation.h"
#include "ending.h"
#include "program.h"
#include "reader.h"
#include "replay.h"

#include <filesystem>

namespace nf::commands
{
namespace
{

int debug_recording(const replay::Recording &recording, const replay::Result &result,
                    const ReplayArguments &arguments)
{
    debug::Session session(recording.run,
                           std::filesystem::path(arguments.file).filename().string());
    session.timeline.go_to(replay::tick_of_interest(recording, result));
    return converse(session, arguments.script);
}

} // namespace

int replay(const ReplayArguments &arguments)
{
    if (!arguments.script.empty() && !arguments.debug) {
        throw FileError("--script needs --debug");
    }
    const replay::Recording recording = replay::read_file(arguments.file);
    const replay::Result result = replay::replay(recording);
    write_text("-", replay::summary(recording, result));
    const int done = arguments.debug ? debug_recording(recording, result, arguments) : LIMITS_HOLD;
    return done == LIMITS_HOLD && result.difference ? LIMIT_BROKEN : done;
}

void describe(CLI::App &command, ReplayArguments &arguments)
{
    command
        .add_option("file", arguments.file,
                    "a recording: what the console's `dump` sent, as it was logged")
        ->required();
    command.add_flag("--debug", arguments.debug,
                     "step through it, beginning where it departs, else at the fault");
    describe_script(command, arguments.script);
}

} // namespace nf::commands
