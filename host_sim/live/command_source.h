/* SPDX-License-Identifier: MIT */
// Lines of commands that never hold up whoever asks for them: of a file, or of a pipe or a terminal
// on standard input.
#pragma once

#include "line_reader.h"
#include "whole_input.h"

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace nf::live
{

class CommandSource
{
public:
    // "-" or empty: standard input. Throws InputError with the file's name.
    explicit CommandSource(const std::string &path);
    ~CommandSource();
    CommandSource(const CommandSource &) = delete;
    CommandSource &operator=(const CommandSource &) = delete;

    // The next line, if it has come. Throws InputError for one that is too long for a command.
    std::optional<std::string> next();

    // There will be none any more.
    bool has_ended() const
    {
        return ended_ && lines_.empty();
    }

    // The lines as those of a dialogue: each is waited for, and echoed to `echo`.
    std::unique_ptr<debug::LineReader> reader(std::FILE *echo);

private:
    void take_what_has_come();

    int file_;
    bool ended_ = false;
    LineCollector collector_;
    std::deque<std::string> lines_;
};

} // namespace nf::live
