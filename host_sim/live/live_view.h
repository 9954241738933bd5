/* SPDX-License-Identifier: MIT */
// What a person sees of a running board, and types.
#pragma once

#include "follower.h"

#include <memory>
#include <optional>
#include <string>

namespace nf::live
{

class LiveView
{
public:
    virtual ~LiveView() = default;

    // A line that stays.
    virtual void say(const std::string &line) = 0;

    // How the board is now; call as often as you like.
    virtual void show(const Follower &follower) = 0;

    // A line that was typed. None where nobody types here.
    virtual std::optional<std::string> typed() = 0;

    // The terminal is given to somebody else, and taken back.
    virtual void leave() = 0;
    virtual void enter() = 0;
};

// Lines to standard output: what stays, and each second how the board is.
std::unique_ptr<LiveView> plain_view();

// The whole terminal.
std::unique_ptr<LiveView> terminal_view();

} // namespace nf::live
