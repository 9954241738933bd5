// SPDX-License-Identifier: MIT
// A run in slices. run.start prepares it, run.advance goes on, then run.result and run.column have
// what it was. Another run.start with other signals runs the same again: a run is a function of its
// files. With "trace" it writes that file.
#include "answers.h"
#include "calls.h"
#include "recorded_signals.h"

#include "fault_line.h"
#include "report.h"
#include "scenario_run.h"
#include "trace.h"

#include <memory>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::web::run_session
{
namespace
{

struct RunSession : TickSink {
    RunSession(const Choice &choice, const std::vector<std::string> &names,
               const std::string &trace_path)
        : config(load_scenario(choice.scenario, choice.with, choice.set)),
          run(config, config, options), signals(names, static_cast<std::size_t>(run.script().end()))
    {
        options.sink = this;
        if (!trace_path.empty()) {
            trace.emplace(trace_path, false);
        }
    }

    void add(const Tick &tick) override
    {
        signals.add(tick);
        if (trace) {
            trace->add(tick);
        }
    }

    void finish()
    {
        result = run.finish();
        if (trace) {
            trace->close();
        }
    }

    // The run keeps references to these.
    Config config;
    RunOptions options;
    ScenarioRun run;
    RecordedSignals signals;
    std::optional<Trace> trace;
    std::optional<RunResult> result;
};

// One at a time: a page shows one run.
std::unique_ptr<RunSession> session;

RunSession &open_session()
{
    if (!session) {
        throw std::runtime_error("there is no run");
    }
    return *session;
}

Json start(const Json &given)
{
    session.reset(); // its memory is needed
    session = std::make_unique<RunSession>(choice_of(given), texts_of(given, "signals"),
                                           given.value("trace", ""));
    const ScriptedRun &script = session->run.script();
    const Config &config = session->config;
    return {{"ticks", script.end()},          {"period_s", script.sim().bases().control_period_s},
            {"title", config.scenario.title}, {"motor", config.motor.name},
            {"board", config.board.name},     {"tuning", config.tuning.name}};
}

Json advance(const Json &given)
{
    RunSession &s = open_session();
    s.run.advance(given.at("ticks").get<int64_t>());
    if (s.run.is_done() && !s.result) {
        s.finish();
    }
    return {{"tick", s.run.script().tick()}, {"done", s.run.is_done()}};
}

const RunResult &result_of(const RunSession &s)
{
    if (!s.result) {
        throw std::runtime_error("the run is not at its end");
    }
    return *s.result;
}

Json rows_of(const RunSession &s)
{
    Json rows = Json::array();
    for (const ResultRow &row : result_rows(s.config, result_of(s))) {
        rows.push_back(
            {{"name", row.name}, {"value", row.value}, {"limit", row.limit}, {"holds", row.holds}});
    }
    return rows;
}

Json faults_of(const RunSession &s)
{
    const RunResult &result = result_of(s);
    const Bases bases = make_bases(s.config.motor, s.config.board);
    Json faults = Json::array();
    for (const FoundFault &fault : result.faults) {
        faults.push_back(
            fault_json(fault, result.time_s(fault), fault_measure(fault, bases, &s.config.board)));
    }
    return faults;
}

Json parameters_of(const RunResult &result)
{
    Json parameters = Json::array();
    for (const Parameter &p : result.parameters) {
        parameters.push_back({{"name", p.name},
                              {"configured", p.configured},
                              {"estimated", p.estimated},
                              {"actual", p.actual}});
    }
    return parameters;
}

Json result(const Json &given)
{
    (void)given;
    const RunSession &s = open_session();
    const RunResult &found = result_of(s);
    return {{"rows", rows_of(s)},
            {"accepted", violations(s.config, found).empty()},
            {"notes", notes_of(s.config, found)},
            {"faults", faults_of(s)},
            {"states", states_json(s.signals.states())},
            {"parameters", parameters_of(found)},
            {"text", table_text(s.config, found)},
            {"json", json_text(s.config, found)}};
}

Json times(const Json &given)
{
    (void)given;
    return block_of(open_session().signals.times_s());
}

Json column(const Json &given)
{
    const std::string name = given.at("signal");
    const std::vector<float> *values = open_session().signals.values(name);
    if (values == nullptr) {
        throw std::runtime_error(fmt::format("{} is not recorded in this run", name));
    }
    return block_of(*values);
}

Json signals(const Json &given)
{
    (void)given;
    return signals_json(open_session().run.script().sim());
}

} // namespace

const Calls &calls()
{
    static const Calls all = {{"run.start", start},   {"run.advance", advance},
                              {"run.result", result}, {"run.times", times},
                              {"run.column", column}, {"run.signals", signals}};
    return all;
}

} // namespace nf::web::run_session
