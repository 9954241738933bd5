// SPDX-License-Identifier: MIT
// The stepper of `motorsim debug`, over a scenario, over the recent past of what is played with,
// and over a recording. step.open chooses, step.execute takes the stepper's own commands, step.look
// shows the present tick.
#include "answers.h"
#include "calls.h"
#include "sessions.h"

#include "commands.h"
#include "diff.h"
#include "names.h"
#include "stages.h"

extern "C" {
#include "fault_text.h"
}

#include <memory>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::web::step_session
{
namespace
{

struct ScenarioStepper {
    explicit ScenarioStepper(const Choice &choice)
        : config(load_scenario(choice.scenario, choice.with, choice.set)), session(config)
    {
    }

    // The session keeps a reference to it.
    Config config;
    debug::Session session;
};

std::unique_ptr<ScenarioStepper> scenario;

// By what is open, and not by its address: another part may begin anew.
std::string source;

// Of a slice. More than the ticks from a snapshot to the next, so that a way back is one slice.
constexpr int64_t SLICE_TICKS = 8192;
int64_t ticks_left = 0;

bool is_slice_over()
{
    ticks_left--;
    return ticks_left < 0;
}

debug::Session *stepper_of(const std::string &name)
{
    if (name == "play") {
        return play_session::stepper();
    }
    if (name == "recording") {
        return replay_session::stepper();
    }
    return scenario ? &scenario->session : nullptr;
}

debug::Session &open_stepper()
{
    debug::Session *const found = stepper_of(source);
    if (found == nullptr) {
        throw std::runtime_error("there is nothing to step through");
    }
    return *found;
}

Json open(const Json &given)
{
    const std::string wanted = given.at("source");
    if (wanted == "scenario") {
        scenario.reset(); // its memory is needed
        scenario = std::make_unique<ScenarioStepper>(choice_of(given));
    }
    if (stepper_of(wanted) == nullptr) {
        throw std::runtime_error(wanted == "play" ? "nothing has been played yet"
                                                  : "no recording is open");
    }
    source = wanted;
    const debug::Timeline &timeline = open_stepper().timeline;
    return {{"name", open_stepper().scenario}, {"recorded", timeline.run().is_recorded()}};
}

// What is left of a command whose slice is over; empty when it is done. A command that runs on has
// no target.
std::string rest_of(const debug::Session &session, const std::string &line)
{
    if (ticks_left >= 0) {
        return "";
    }
    return session.wanted ? fmt::format("goto {}", *session.wanted) : line;
}

Json execute(const Json &given)
{
    const std::string line = given.at("line");
    debug::Session &session = open_stepper();
    ticks_left = SLICE_TICKS;
    session.stop = is_slice_over;
    const debug::Answer answer = debug::execute(session, line);
    const bool refused = answer.outcome == debug::Outcome::refused;
    return {{"text", answer.text},
            {"refused", refused},
            {"rest", refused ? "" : rest_of(session, line)},
            {"tick", session.timeline.now()},
            {"last", session.timeline.last()}};
}

Json complete(const Json &given)
{
    return debug::completions(given.at("before"), given.at("word"));
}

Json stages_json(const Tick &tick)
{
    Json stages = Json::array();
    for (const debug::Stage *const stage : debug::stages_of(tick)) {
        Json rows = Json::array();
        for (const char *const name : stage->signals) {
            rows.push_back(signal_json(*debug::named_signal(name).signal, tick));
        }
        stages.push_back({{"title", stage->title}, {"rows", rows}});
    }
    return stages;
}

Json diff_json(const debug::Timeline &timeline)
{
    Json rows = Json::array();
    for (const debug::Comparison &row :
         debug::diff_tick(timeline.before(), timeline.tick(), timeline.run().built())) {
        rows.push_back({{"module", row.module},
                        {"quantity", row.quantity},
                        {"unit", row.unit},
                        {"drive", row.drive},
                        {"reference", row.reference},
                        {"tolerance", row.tolerance},
                        {"departs", row.departs()}});
    }
    return rows;
}

// The drive's count of ticks wraps, that of a run does not.
Json fault_of(const debug::Timeline &timeline)
{
    const drive_t &drive = timeline.run().sim().drive();
    if (drive.state != DRIVE_STATE_FAULT) {
        return nullptr;
    }
    const fault_text_t &text = *fault_text(drive.fault.id);
    const uint32_t ago = static_cast<uint32_t>(timeline.now()) - drive.fault.tick;
    return {{"name", text.name},
            {"advice", found_fault(drive, timeline.run().sim().bases()).advice},
            {"tick", timeline.now() - ago}};
}

std::vector<std::string> breaks_of(const debug::Session &session)
{
    std::vector<std::string> texts;
    texts.reserve(session.breaks.size());
    for (const debug::Break &one : session.breaks) {
        texts.push_back(one.text);
    }
    return texts;
}

Json look(const Json &given)
{
    (void)given;
    const debug::Session &session = open_stepper();
    const debug::Timeline &timeline = session.timeline;
    return {{"tick", timeline.now()},
            {"first", timeline.first()},
            {"last", timeline.last()},
            {"time_s", timeline.tick().time_s},
            {"position", session.position_text()},
            {"state", state_name(timeline.run().sim().drive().state)},
            {"fault", fault_of(timeline)},
            {"stages", stages_json(timeline.tick())},
            {"diff", diff_json(timeline)},
            {"edits", timeline.edits()},
            {"breaks", breaks_of(session)}};
}

} // namespace

const Calls &calls()
{
    static const Calls all = {{"step.open", open},
                              {"step.execute", execute},
                              {"step.complete", complete},
                              {"step.look", look}};
    return all;
}

} // namespace nf::web::step_session
