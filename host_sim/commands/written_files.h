/* SPDX-License-Identifier: MIT */
// The files that a command writes.
#pragma once

#include "config.h"

#include <string>
#include <vector>

namespace nf::commands
{

// What CLI11 asks of a file to write; empty where it is one.
std::string not_a_file(const std::string &name);

// Likewise where standard output has the results.
std::string not_a_trace_file(const std::string &name);

// A file of the command line, by its option; "" where it is not given.
struct NamedFile {
    const char *option;
    std::string path;
};
using NamedFiles = std::vector<NamedFile>;

// Nothing is written over what was read, by the configuration or as one of `inputs`, nor twice to
// the same file. Throws FileError.
void check_outputs(const Config &config, const NamedFiles &outputs, const NamedFiles &inputs = {});

// Refuses a file that is there already, unless it may be replaced.
void check_new(const std::string &output, bool overwrite);

// Of what takes a while: what cannot be written is said before it.
void check_writable(const std::vector<std::string> &paths);

} // namespace nf::commands
