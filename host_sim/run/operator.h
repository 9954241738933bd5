/* SPDX-License-Identifier: MIT */
// Who asks the drive to run, to stop and to forget a fault: [[scenario.request]].
//
// RUN is wanted from the start on and asked for as soon as the drive is READY; entries change the
// wish. A clear is held until the drive has left FAULT, and has no effect where there is none. It
// ends the wish to run unless its entry renews it: then the drive is started again once it is
// READY.
#pragma once

#include "sim.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nf
{

class Operator
{
public:
    // Times count from tick `zero`; requests before tick 0 act there.
    Operator(const std::vector<RequestEntry> &requests, double period_s, int64_t zero);

    // A person asks, from the next act() on.
    void take(const RequestEntry &entry);

    // Before control() of each tick. Call with ticks that rise.
    void act(int64_t tick, Simulation &sim);

    // DRIVE_REQUEST_RUN, DRIVE_REQUEST_CLEAR or 0, as of the last act().
    uint8_t request() const
    {
        return request_;
    }

private:
    struct Request {
        int64_t tick;
        RequestEntry entry;
    };
    std::vector<Request> requests_;
    std::size_t next_ = 0;
    bool run_ = true;
    bool clearing_ = false;
    uint8_t request_ = 0;
};

} // namespace nf
