/* SPDX-License-Identifier: MIT */
// What several parts of the bench tell the page in the same form.
#pragma once

#include "calls.h"
#include "found_fault.h"
#include "recorded_signals.h"
#include "scope.h"
#include "signals.h"

namespace nf::web
{

// All that there are, in the order of the table; units are those of this configuration.
Json signals_json(const Simulation &sim);

// Likewise those that are known where only the frames of a run are: not what is true of its motor.
Json recorded_signals_json(const Simulation &sim);

// A signal at a tick: name, value in its unit, and of a word of the firmware the raw integer as
// text, as it may be longer than the page's numbers. `word`: the value of a state or a fault.
Json signal_json(const SignalInfo &signal, const Tick &tick);

// `measure`: what fault_measure() says of it.
Json fault_json(const FoundFault &fault, double time_s, const std::string &measure);

Json states_json(const std::vector<StateChange> &changes);

// The state machine as the firmware has it: which state may follow which.
Json moves_json();

// Of "signals" and "span_s", what the screen shows of them.
Scope scope_of(const Json &given, double period_s);

// Name: the points that have become whole.
Json columns_json(const Scope &scope);

} // namespace nf::web
