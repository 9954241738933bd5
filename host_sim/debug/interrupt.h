/* SPDX-License-Identifier: MIT */
// Ctrl-C as a request to stop what runs, not as the end of the process.
#pragma once

namespace nf::debug
{

// As long as it lives, SIGINT is only noted. One at a time: a process has one handler.
class InterruptWatch
{
public:
    InterruptWatch();
    ~InterruptWatch();
    InterruptWatch(const InterruptWatch &) = delete;
    InterruptWatch &operator=(const InterruptWatch &) = delete;
};

// Since the last forget_interrupt(); never without a watch.
bool was_interrupted();
void forget_interrupt();

} // namespace nf::debug
