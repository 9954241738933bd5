/* SPDX-License-Identifier: MIT */
// A quantity that changes in steps at given times.
#pragma once

#include "config.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace nf
{

// A step acts from the tick nearest to its time on. The value before the first step is 0.
class Profile
{
public:
    // Times count from tick `zero`; steps before tick 0 act at tick 0.
    Profile(const std::vector<TimedValue> &steps, double period_s, int64_t zero)
    {
        for (const TimedValue &step : steps) {
            steps_.push_back({zero + std::llround(step.time_s / period_s), step.value});
        }
    }

    // True when the value is a new one at this tick. Call with ticks that rise.
    bool advance(int64_t tick)
    {
        if (next_ == steps_.size() || tick < steps_[next_].tick) {
            return false;
        }
        const double before = value_;
        while (next_ < steps_.size() && tick >= steps_[next_].tick) {
            value_ = steps_[next_].value;
            next_++;
        }
        return value_ < before || value_ > before;
    }

    // Another value, until the next step.
    void set(double value)
    {
        value_ = value;
    }

    double value() const
    {
        return value_;
    }

private:
    struct Step {
        int64_t tick;
        double value;
    };
    std::vector<Step> steps_;
    std::size_t next_ = 0;
    double value_ = 0;
};

} // namespace nf
