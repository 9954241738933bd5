// SPDX-License-Identifier: MIT
#include "operator.h"

#include <cmath>

namespace nf
{

Operator::Operator(const std::vector<RequestEntry> &requests, double period_s, int64_t zero)
{
    requests_.reserve(requests.size());
    for (const RequestEntry &entry : requests) {
        requests_.push_back({zero + std::llround(entry.time_s / period_s), entry});
    }
}

void Operator::take(const RequestEntry &entry)
{
    if (entry.clear) {
        clearing_ = true;
        run_ = false;
    }
    run_ = entry.run.value_or(run_);
}

void Operator::act(int64_t tick, Simulation &sim)
{
    const drive_state_t state = sim.drive().state;
    while (next_ < requests_.size() && tick >= requests_[next_].tick) {
        take(requests_[next_].entry);
        next_++;
    }
    clearing_ = clearing_ && state == DRIVE_STATE_FAULT;
    if (clearing_) {
        request_ = DRIVE_REQUEST_CLEAR;
    } else if (run_ && state == DRIVE_STATE_READY) {
        request_ = DRIVE_REQUEST_RUN;
    } else if (!run_ || request_ == DRIVE_REQUEST_CLEAR) {
        request_ = 0;
    }
    sim.request(request_);
}

} // namespace nf
