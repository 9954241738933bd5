// SPDX-License-Identifier: MIT
#include "signals_command.h"

#include "ending.h"
#include "program.h"
#include "table.h"

namespace nf::commands
{

int signals(const Choice &choice)
{
    write_text("-", debug::table_json(choice.load()));
    return LIMITS_HOLD;
}

} // namespace nf::commands
