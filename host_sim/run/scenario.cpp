// SPDX-License-Identifier: MIT
#include "scenario.h"

#include "scenario_run.h"

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr int64_t PROGRESS_TICKS = 1 << 14;

} // namespace

RunResult run_scenario(const Config &config, const RunOptions &options)
{
    return run_scenario(config, config, options);
}

RunResult run_scenario(const Config &real, const Config &believed, const RunOptions &options)
{
    ScenarioRun run(real, believed, options);
    while (!run.is_done()) {
        if (options.progress) {
            options.progress(static_cast<double>(run.script().tick()) /
                             static_cast<double>(run.script().end()));
        }
        run.advance(PROGRESS_TICKS);
    }
    if (options.progress) {
        options.progress(1.0);
    }
    return run.finish();
}

std::optional<double> figure(const RunResult &result, const std::string &metric)
{
    for (const MetricField &field : metric_fields()) {
        if (metric == field.name) {
            return result.metrics.*field.value;
        }
    }
    if (metric == SATURATION_INTERNAL_COUNT) {
        return static_cast<double>(result.saturations.internal_count());
    }
    return std::nullopt;
}

const char *flag_text(bool value)
{
    return value ? "true" : "false";
}

std::string Violation::text() const
{
    return fmt::format("{} = {}, limit: {}", metric, value.empty() ? "none" : value, limit);
}

const AcceptLimits *limits_of(const Config &config)
{
    return config.scenario.limits(selection_name(config.sources.imperfections));
}

std::vector<Violation> violations(const Config &config, const RunResult &result)
{
    std::vector<Violation> found;
    const AcceptLimits *limits = limits_of(config);
    if (limits == nullptr) {
        return found;
    }
    for (const FlagField &field : flag_fields()) {
        const auto wanted = limits->flags.find(field.name);
        const bool value = result.metrics.*field.value;
        if (wanted != limits->flags.end() && value != wanted->second) {
            found.push_back({field.name, flag_text(value), flag_text(wanted->second)});
        }
    }
    for (const auto &[metric, limit] : limits->upper) {
        const std::optional<double> value = figure(result, metric);
        const bool holds = value && *value <= limit;
        if (!holds) {
            found.push_back(
                {metric, value ? fmt::format("{:.4g}", *value) : "", fmt::format("{:g}", limit)});
        }
    }
    return found;
}

} // namespace nf
