// SPDX-License-Identifier: MIT
// A recording of the flight recorder, run again. replay.open takes a file, replay.columns its
// curves; step.open steps through it.
#include "answers.h"
#include "calls.h"
#include "sessions.h"

#include "fault_line.h"
#include "reader.h"
#include "replay.h"

#include <memory>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::web::replay_session
{
namespace
{

struct ReplaySession {
    ReplaySession(replay::Recording found, const std::string &name)
        : recording(std::move(found)), result(replay::replay(recording)),
          stepper(recording.run, name)
    {
        stepper.timeline.go_to(replay::tick_of_interest(recording, result));
    }

    replay::Recording recording;
    replay::Result result;
    debug::Session stepper;
    std::unique_ptr<RecordedSignals> signals;
};

std::unique_ptr<ReplaySession> session;

ReplaySession &open_session()
{
    if (!session) {
        throw std::runtime_error("no recording is open");
    }
    return *session;
}

double period_of(const ReplaySession &s)
{
    return s.recording.run.image.bases.control_period_s;
}

Json faults_of(const ReplaySession &s)
{
    const FoundFault fault = {s.recording.fault(), s.result.fault.swing_hz, s.result.fault.advice};
    if (fault.id == FAULT_NONE) {
        return Json::array();
    }
    const auto at = static_cast<double>(s.recording.run.tick_of(fault.tick));
    return Json::array(
        {fault_json(fault, at * period_of(s), fault_measure(fault, s.recording.run.image.bases))});
}

Json head_of(const ReplaySession &s)
{
    return {{"summary", replay::summary(s.recording, s.result)},
            {"equal", !s.result.difference},
            {"step_tick", replay::tick_of_interest(s.recording, s.result)},
            {"faults", faults_of(s)},
            {"signals", recorded_signals_json(s.stepper.timeline.run().sim())}};
}

// A recording that cannot be read leaves the one before it open.
Json open(const Json &given)
{
    const std::string file = given.at("file");
    session = std::make_unique<ReplaySession>(replay::read_file(file), file);
    return head_of(*session);
}

// Of the recording that is open; null without one.
Json head(const Json &given)
{
    (void)given;
    return session ? head_of(*session) : Json(nullptr);
}

Json columns(const Json &given)
{
    ReplaySession &s = open_session();
    const std::vector<std::string> names = texts_of(given, "signals");
    s.signals = std::make_unique<RecordedSignals>(names, s.recording.run.frames.size());
    for (ScriptedRun run(s.recording.run); run.tick() < run.end(); run.advance()) {
        s.signals->add(run.control());
    }
    Json columns = Json::object();
    for (const std::string &name : names) {
        columns[name] = block_of(*s.signals->values(name));
    }
    return {{"times", block_of(s.signals->times_s())},
            {"columns", columns},
            {"states", states_json(s.signals->states())}};
}

} // namespace

debug::Session *stepper()
{
    return session ? &session->stepper : nullptr;
}

const Calls &calls()
{
    static const Calls all = {
        {"replay.open", open}, {"replay.head", head}, {"replay.columns", columns}};
    return all;
}

} // namespace nf::web::replay_session
