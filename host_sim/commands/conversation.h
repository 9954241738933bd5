/* SPDX-License-Identifier: MIT */
// A debugger's commands: of a file, of a pipe, or of a person.
#pragma once

#include "session.h"

#include <string>

#include <CLI/CLI.hpp>

namespace nf::commands
{

// `-` is a pipe, also where a person types; so is "" where standard input is no terminal. Returns
// the exit status.
int converse(debug::Session &session, const std::string &script);

void describe_script(CLI::App &command, std::string &script);

} // namespace nf::commands
