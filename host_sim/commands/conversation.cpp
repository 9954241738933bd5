// SPDX-License-Identifier: MIT
#include "conversation.h"

#include "commands.h"
#include "console.h"
#include "ending.h"
#include "program.h"
#include "whole_input.h"
#include "written_files.h"

#include <cstdio>
#include <memory>

#include <unistd.h>

namespace nf::commands
{
namespace
{

constexpr const char *STDIN = "standard input";

int talk(debug::Session &session, debug::LineReader &reader)
{
    return debug::converse(session, reader, stdout) ? LIMITS_HOLD : BAD_INPUT;
}

} // namespace

int converse(debug::Session &session, const std::string &script)
{
    const bool piped = script == "-";
    if (!script.empty() && !piped) {
        const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(
            fdopen(open_input(script), "rb"), std::fclose);
        return talk(session, *debug::stream_reader(file.get(), stdout, script));
    }
    check_standard_input();
    const bool person = !piped && isatty(STDIN_FILENO) != 0;
    return talk(session, person ? *debug::terminal_reader(debug::completions)
                                : *debug::stream_reader(stdin, stdout, STDIN));
}

void describe_script(CLI::App &command, std::string &script)
{
    command
        .add_option("--script", script,
                    "commands from a file; - is standard input; status 2 when one fails")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

} // namespace nf::commands
