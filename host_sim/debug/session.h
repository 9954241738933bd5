/* SPDX-License-Identifier: MIT */
// One debugging session: a run, what it stops at, what is watched.
#pragma once

#include "expression.h"
#include "interrupt.h"
#include "timeline.h"
#include "vocabulary.h"

#include <optional>
#include <string>
#include <vector>

namespace nf::debug
{

// Something that stops a run when it becomes true; for a change of state, when it changes.
struct Break {
    std::string text;
    Value value;
    bool on_change;
    double last; // in the tick before
};

class Session
{
public:
    // Throws ConfigError. The configuration must outlive it.
    explicit Session(const Config &config, int64_t keep = Timeline::FOR_EVER)
        : timeline(config, keep), scenario(config.scenario.id)
    {
    }
    // Of a recording, which is called by this name.
    Session(const RecordedRun &recorded, const std::string &name)
        : timeline(recorded), scenario(name)
    {
    }

    // Forwards until one of the breaks, the condition, an interrupt or the last tick. The reason as
    // a line. After an interrupt the same call goes on as if there had been none.
    std::string run_until(const Value &condition, const std::string &text);

    // What to say before the position there: nothing, or that an interrupt came before.
    std::string go_to(int64_t tick);

    // Where the last go_to() wanted to be, if an interrupt came before.
    std::optional<int64_t> wanted;
    // Asked once a tick that goes by: whether there is an interrupt.
    bool (*stop)() = was_interrupted;

    // "tick 4711  t = 0.4711 s  RUN  999.8 rpm", then what is watched.
    std::string position_text() const;

    Timeline timeline;
    std::string scenario;
    std::vector<Break> breaks;
    std::vector<Named> watched;

private:
    void arm();
    const Break *struck();
};

} // namespace nf::debug
