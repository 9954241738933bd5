// SPDX-License-Identifier: MIT
#include "recorded_signals.h"

#include "vocabulary.h"

namespace nf::web
{

RecordedSignals::RecordedSignals(const std::vector<std::string> &names, std::size_t ticks)
{
    times_s_.reserve(ticks);
    for (const std::string &name : names) {
        columns_.push_back({debug::named_signal(name).signal, {}});
        columns_.back().values.reserve(ticks);
    }
}

void RecordedSignals::add(const Tick &tick)
{
    times_s_.push_back(tick.time_s);
    for (Column &column : columns_) {
        column.values.push_back(static_cast<float>(si_value(*column.signal, tick)));
    }
    const drive_state_t state = tick.sim->drive().state;
    if (states_.empty() || states_.back().state != state) {
        states_.push_back({tick.time_s, state});
    }
}

const std::vector<float> *RecordedSignals::values(const std::string &name) const
{
    for (const Column &column : columns_) {
        if (name == column.signal->name) {
            return &column.values;
        }
    }
    return nullptr;
}

} // namespace nf::web
