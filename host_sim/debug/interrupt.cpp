// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <csignal>

namespace nf::debug
{
namespace
{

volatile std::sig_atomic_t noted = 0; // a handler may write nothing else

struct sigaction before = {};

void note(int)
{
    noted = 1;
}

} // namespace

// Not SA_RESTART: what waits for a key has to come back.
InterruptWatch::InterruptWatch()
{
    struct sigaction action = {};
    action.sa_handler = note;
    sigemptyset(&action.sa_mask);
    forget_interrupt();
    sigaction(SIGINT, &action, &before);
}

InterruptWatch::~InterruptWatch()
{
    sigaction(SIGINT, &before, nullptr);
}

bool was_interrupted()
{
    return noted != 0;
}

void forget_interrupt()
{
    noted = 0;
}

} // namespace nf::debug
