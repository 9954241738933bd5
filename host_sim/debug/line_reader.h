/* SPDX-License-Identifier: MIT */
// Where a session's commands come from: a person at a terminal, with editing, history and
// completion, or a file or pipe.
#pragma once

#include <cstddef>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace nf::debug
{

class LineReader
{
public:
    virtual ~LineReader() = default;
    // The next line without its end; none at the end of the input.
    virtual std::optional<std::string> next(const std::string &prompt) = 0;
    // A mistake is then seen by nobody while the session goes on.
    virtual bool is_unattended() const = 0;
};

// The words that a line may go on with from its last one.
using Complete = std::function<std::vector<std::string>(const std::string &line_before,
                                                        const std::string &word)>;

// One at a time: the library below keeps its state in globals.
std::unique_ptr<LineReader> terminal_reader(const Complete &complete);

constexpr std::size_t LINE_READABLE = 500; // of a command that is echoed

// Echoes prompt and line to `echo`, so that the output reads like a session. Does not own the
// files. `name`: of the script. next() throws InputError for a line that is too long for a command.
std::unique_ptr<LineReader> stream_reader(std::FILE *from, std::FILE *echo,
                                          const std::string &name);

} // namespace nf::debug
