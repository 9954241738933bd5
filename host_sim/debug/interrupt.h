/* SPDX-License-Identifier: MIT */
// Ctrl-C as a request to stop what runs, not as the end of the process.
#pragma once

#include <vector>

namespace nf::debug
{

// What tells a program to end: a person (SIGINT), the system (SIGTERM), the terminal that is gone
// (SIGHUP).
std::vector<int> ending_signals();

// As long as it lives, its signals are only noted; then they do what they did before. One may live
// within another.
class InterruptWatch
{
public:
    InterruptWatch(); // SIGINT
    explicit InterruptWatch(const std::vector<int> &signals);
    ~InterruptWatch();
    InterruptWatch(const InterruptWatch &) = delete;
    InterruptWatch &operator=(const InterruptWatch &) = delete;

private:
    struct Before;
    std::vector<Before> before_;
};

// Since the last forget_interrupt(); never without a watch.
bool was_interrupted();

// Of SIGINT alone: another signal is no Ctrl-C that a person means for one command, and stays
// noted.
void forget_interrupt();

// By another signal than SIGINT: there will be no more lines.
bool was_ended();

} // namespace nf::debug
