/* SPDX-License-Identifier: MIT */
// Chosen signals of all ticks of a run, and when the drive's state changed.
#pragma once

#include "signals.h"

#include <string>
#include <vector>

namespace nf::web
{

struct StateChange {
    double time_s;
    drive_state_t state; // from then on
};

class RecordedSignals : public TickSink
{
public:
    // Throws for an unknown name, with the near ones.
    RecordedSignals(const std::vector<std::string> &names, std::size_t ticks);

    void add(const Tick &tick) override;

    // One number a tick so far; NULL for what is not recorded.
    const std::vector<float> *values(const std::string &name) const;
    const std::vector<double> &times_s() const
    {
        return times_s_;
    }
    const std::vector<StateChange> &states() const
    {
        return states_;
    }

private:
    struct Column {
        const SignalInfo *signal;
        std::vector<float> values;
    };
    std::vector<double> times_s_;
    std::vector<Column> columns_;
    std::vector<StateChange> states_;
};

} // namespace nf::web
