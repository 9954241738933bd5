// SPDX-License-Identifier: MIT
#include "debug_command.h"

#include "conversation.h"

namespace nf::commands
{

int debug(const DebugArguments &arguments)
{
    const Config config = arguments.load();
    debug::Session session(config);
    return converse(session, arguments.script);
}

void describe(CLI::App &command, DebugArguments &arguments)
{
    describe(command, static_cast<Choice &>(arguments));
    describe_script(command, arguments.script);
}

} // namespace nf::commands
