// SPDX-License-Identifier: MIT
#include "report.h"

#include "dimensionless.h"
#include "fault_line.h"
#include "names.h"

#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf
{
namespace
{

std::vector<std::string> imperfection_names(const Config &config)
{
    std::vector<std::string> names;
    names.reserve(config.sources.imperfections.size());
    for (const std::string &file : config.sources.imperfections) {
        names.push_back(std::filesystem::path(file).stem().string());
    }
    return names;
}

std::string line(const std::string &name, const std::string &value, const std::string &limit,
                 bool holds)
{
    const char *verdict = limit.empty() ? "" : holds ? "ok" : "NOT MET";
    const std::string text = fmt::format("  {:<28}{:>10}  {:>10}  {}", name, value, limit, verdict);
    return text.substr(0, text.find_last_not_of(' ') + 1) + '\n';
}

const AcceptLimits &limits_or_none(const Config &config)
{
    static const AcceptLimits NO_LIMITS{};
    const AcceptLimits *found = limits_of(config);
    return found == nullptr ? NO_LIMITS : *found;
}

ResultRow number_row(const std::string &metric, double value, const AcceptLimits &limits)
{
    const auto limit = limits.upper.find(metric);
    const bool limited = limit != limits.upper.end();
    return {metric, fmt::format("{:.4g}", value), limited ? fmt::format("{:g}", limit->second) : "",
            limited && value <= limit->second};
}

ResultRow flag_row(const FlagField &field, const MetricValues &metrics, const AcceptLimits &limits)
{
    const bool value = metrics.*field.value;
    const auto wanted = limits.flags.find(field.name);
    const bool limited = wanted != limits.flags.end();
    return {field.name, flag_text(value), limited ? flag_text(wanted->second) : "",
            limited && value == wanted->second};
}

void add_saturations(const Saturations &saturations, std::vector<ResultRow> &rows)
{
    for (std::size_t k = 0; k < SIGNAL_COUNT; k++) {
        if (saturations.ticks()[k] > 0) {
            rows.push_back(
                {fmt::format("{} {}", k < FIRST_LIMIT ? "saturated" : "at limit", signal_name(k)),
                 fmt::format("{} ticks", saturations.ticks()[k]), "", false});
        }
    }
}

} // namespace

// Of the files, then of the run.
std::vector<std::string> notes_of(const Config &config, const RunResult &result)
{
    std::vector<std::string> notes = config.scenario.notes;
    notes.insert(notes.end(), result.notes.begin(), result.notes.end());
    return notes;
}

std::vector<ResultRow> result_rows(const Config &config, const RunResult &result)
{
    const AcceptLimits &limits = limits_or_none(config);
    std::vector<ResultRow> rows;
    for (const FlagField &field : flag_fields()) {
        rows.push_back(flag_row(field, result.metrics, limits));
    }
    for (const MetricField &field : metric_fields()) {
        const std::optional<double> &value = result.metrics.*field.value;
        if (value) {
            rows.push_back(number_row(field.name, *value, limits));
        } else if (limits.upper.count(field.name) > 0) {
            rows.push_back(
                {field.name, "none", fmt::format("{:g}", limits.upper.at(field.name)), false});
        }
    }
    rows.push_back(number_row(SATURATION_INTERNAL_COUNT,
                              static_cast<double>(result.saturations.internal_count()), limits));
    add_saturations(result.saturations, rows);
    return rows;
}

std::string json_text(const Config &config, const RunResult &result)
{
    nlohmann::ordered_json json;
    json["scenario"] = config.scenario.id;
    json["with"] = imperfection_names(config);
    json["set"] = config.sources.overrides;
    json["notes"] = notes_of(config, result);
    json["seed"] = config.scenario.seed;
    for (const MetricField &field : metric_fields()) {
        const std::optional<double> &value = result.metrics.*field.value;
        json[field.name] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
    }
    for (const FlagField &field : flag_fields()) {
        json[field.name] = result.metrics.*field.value;
    }
    json["faults"] = nlohmann::ordered_json::array();
    for (const FoundFault &fault : result.faults) {
        json["faults"].push_back(fault_mark(fault, result.time_s(fault)));
    }
    json["state_final"] = state_name(result.state_final);
    json["gates_enabled_final"] = result.gates_enabled_final;
    for (const Parameter &p : result.parameters) {
        json["parameters"][p.name] = {
            {"configured", p.configured}, {"estimated", p.estimated}, {"actual", p.actual}};
    }
    json["motor"] = {{"pole_pairs", config.motor.pole_pairs},
                     {"rated_speed_rpm", config.motor.rated_speed_rpm},
                     {"max_current_a", config.motor.max_current_a}};
    for (const Dimensionless &number : dimensionless(config)) {
        json["dimensionless"][number.name] = number.value;
    }
    json["saturations"] = nlohmann::ordered_json::object();
    for (std::size_t k = 0; k < SIGNAL_COUNT; k++) {
        json["saturations"][signal_name(k)] = result.saturations.ticks()[k];
    }
    json[SATURATION_INTERNAL_COUNT] = result.saturations.internal_count();
    if (limits_of(config) != nullptr) {
        const std::vector<Violation> broken = violations(config, result);
        json["accepted"] = broken.empty();
        json["failed_limits"] = nlohmann::ordered_json::array();
        for (const Violation &violation : broken) {
            json["failed_limits"].push_back(violation.text());
        }
    }
    return json.dump(2) + '\n';
}

std::string table_text(const Config &config, const RunResult &result)
{
    std::string text = fmt::format(
        "{}: {}\n  {}, tuning {}, imperfections: {}\n\n", config.scenario.id, config.scenario.title,
        config.motor.name, config.tuning.name, selection_name(config.sources.imperfections));
    const std::vector<std::string> notes = notes_of(config, result);
    for (const std::string &note : notes) {
        text += fmt::format("note: {}\n", note);
    }
    text += notes.empty() ? "" : "\n";
    text += fmt::format("  {:<28}{:>10}  {:>10}\n", "", "value", "limit");
    for (const ResultRow &row : result_rows(config, result)) {
        text += line(row.name, row.value, row.limit, row.holds);
    }
    for (const FoundFault &fault : result.faults) {
        text += line("fault", fault_mark(fault, result.time_s(fault)), "", true);
        text +=
            fmt::format("    {}\n    {}\n",
                        fault_measure(fault, make_bases(config.motor, config.board), &config.board),
                        fault.advice);
    }
    text += fmt::format("\n  {:<28}{:>10}  {:>10}  {:>10}\n", "motor", "estimated", "actual",
                        "configured");
    for (const Parameter &p : result.parameters) {
        text += fmt::format("  {:<28}{:>10.4g}  {:>10.4g}  {:>10.4g}\n", p.name, p.estimated,
                            p.actual, p.configured);
    }
    return text;
}

} // namespace nf
