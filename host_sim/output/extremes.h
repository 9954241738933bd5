/* SPDX-License-Identifier: MIT */
// The smallest and the largest value that each intermediate of the drive has in a run: bus,
// reference, voltage and ratios, and the words of its output frame.
#pragma once

#include "signals.h"

#include <limits>
#include <string>
#include <vector>

namespace nf
{

class Extremes : public TickSink
{
public:
    Extremes();

    void add(const Tick &tick) override;

    // After a tick. A list: name, raw min and max, and what makes SI of them, (raw − zero) · one in
    // a unit.
    std::string json_text() const;

private:
    struct Seen {
        const SignalInfo *signal;
        int64_t lowest = std::numeric_limits<int64_t>::max();
        int64_t highest = std::numeric_limits<int64_t>::min();
        Scale scale{};
    };
    std::vector<Seen> seen_;
};

} // namespace nf
