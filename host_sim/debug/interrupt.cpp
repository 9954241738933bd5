// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <csignal>

namespace nf::debug
{
namespace
{

// A handler may write nothing else.
volatile std::sig_atomic_t noted = 0;
volatile std::sig_atomic_t ended = 0;

int watches = 0;

void note(int signal)
{
    noted = 1;
    if (signal != SIGINT) {
        ended = 1;
    }
}

} // namespace

struct InterruptWatch::Before {
    int signal;
    struct sigaction action;
};

std::vector<int> ending_signals()
{
    return {SIGINT, SIGTERM, SIGHUP};
}

InterruptWatch::InterruptWatch() : InterruptWatch(std::vector<int>{SIGINT})
{
}

// Not SA_RESTART: what waits for a key has to come back.
InterruptWatch::InterruptWatch(const std::vector<int> &signals)
{
    struct sigaction action = {};
    action.sa_handler = note;
    sigemptyset(&action.sa_mask);
    if (watches == 0) {
        ended = 0;
    }
    watches++;
    forget_interrupt();
    for (const int signal : signals) {
        Before before = {signal, {}};
        sigaction(signal, &action, &before.action);
        before_.push_back(before);
    }
}

InterruptWatch::~InterruptWatch()
{
    for (const Before &before : before_) {
        sigaction(before.signal, &before.action, nullptr);
    }
    watches--;
}

bool was_interrupted()
{
    return noted != 0 || ended != 0;
}

void forget_interrupt()
{
    noted = 0;
}

bool was_ended()
{
    return ended != 0;
}

} // namespace nf::debug
