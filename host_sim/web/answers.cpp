// SPDX-License-Identifier: MIT
#include "answers.h"

#include "names.h"

#include <algorithm>

extern "C" {
#include "fault_text.h"
#include "transitions.h"
}

namespace nf::web
{

namespace
{

Json signal_entry(const SignalInfo &signal, const Simulation &sim)
{
    return {{"name", signal.name},
            {"unit", unit_text(signal, sim)},
            {"format", format_text(signal, sim)}};
}

} // namespace

Json signals_json(const Simulation &sim)
{
    Json all = Json::array();
    for (const SignalInfo &signal : all_signals()) {
        all.push_back(signal_entry(signal, sim));
    }
    return all;
}

Json recorded_signals_json(const Simulation &sim)
{
    const Tick tick = tick_of_frame(sim, sim.in(), 0);
    Json known = Json::array();
    for (const SignalInfo &signal : all_signals()) {
        if (is_told(signal, tick)) {
            known.push_back(signal_entry(signal, sim));
        }
    }
    return known;
}

Json signal_json(const SignalInfo &signal, const Tick &tick)
{
    Json json = {{"name", signal.name},
                 {"value", si_value(signal, tick)},
                 {"unit", unit_text(signal, *tick.sim)}};
    if (const std::optional<int64_t> raw = raw_value(signal, tick)) {
        json["word"] = word_text(signal, *raw);
        json["raw"] = std::to_string(*raw);
        json["format"] = format_text(signal, *tick.sim);
    }
    if (const std::optional<int64_t> recorded = recorded_value(signal, tick)) {
        json["recorded"] = std::to_string(*recorded);
    }
    return json;
}

Json fault_json(const FoundFault &fault, double time_s, const std::string &measure)
{
    return {{"time_s", time_s},
            {"name", fault_text(fault.id)->name},
            {"measure", measure},
            {"advice", fault.advice}};
}

Json states_json(const std::vector<StateChange> &changes)
{
    Json states = Json::array();
    for (const StateChange &change : changes) {
        states.push_back({{"from_s", change.time_s}, {"name", state_name(change.state)}});
    }
    return states;
}

Json moves_json()
{
    Json moves = Json::array();
    for (uint32_t from = 0; from < DRIVE_STATES; from++) {
        const drive_state_t state = transitions_state(from);
        for (int event = DRIVE_EVENT_NONE; event < DRIVE_EVENTS; event++) {
            const drive_state_t next = transitions_next(state, static_cast<drive_event_t>(event));
            if (next != state) {
                moves.push_back({{"from", state_name(state)}, {"to", state_name(next)}});
            }
        }
    }
    return moves;
}

Scope scope_of(const Json &given, double period_s)
{
    constexpr double BUCKETS_IN_SPAN = 400; // two pixels a bucket
    const double ticks = given.at("span_s").get<double>() / period_s / BUCKETS_IN_SPAN;
    return {texts_of(given, "signals"), std::max<int64_t>(std::llround(ticks), 1)};
}

Json columns_json(const Scope &scope)
{
    Json columns = Json::object();
    for (const Scope::Trace &trace : scope.traces()) {
        columns[trace.signal->name] = block_of(trace.points);
    }
    return columns;
}

} // namespace nf::web
