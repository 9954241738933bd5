#include "scenario_file.h"

#include "event_file.h"
#include "files.h"
#include "suggest.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace nf
{
namespace
{

// Metrics that a scenario may limit, besides `locked`.
const std::vector<std::string> METRICS = {"speed_error_max_rpm",
                                          "speed_error_rms_rpm",
                                          "speed_error_max_pct",
                                          "command_error_settled_pct",
                                          "angle_error_max_deg",
                                          "iq_error_max_a",
                                          "settling_time_s",
                                          "overshoot_pct",
                                          "speed_dip_rpm",
                                          "recovery_time_s",
                                          "position_error_final_rad",
                                          "id_settled_a",
                                          "saturation_internal_count"};
const std::string LOCKED = "locked";
const std::string ANY = "any";
const std::string IDEAL = "ideal";

// What the entries of a list of timed values hold.
struct TimedKey {
    const char *key;
    const char *unit;
    double largest; // either sign
};
constexpr TimedKey SPEED = {"speed_rpm", "rpm", SPEED_COMMAND_MAX_RPM};
constexpr TimedKey POSITION = {"position_rad", "rad", POSITION_COMMAND_MAX_RAD};
constexpr TimedKey TORQUE = {"torque_nm", "N·m", LOAD_MAX_NM};

std::vector<TimedValue> read_list(const std::string &list, const TimedKey &value_key,
                                  const Node &node)
{
    const auto &[key, unit, largest] = value_key;
    check_list(list, {"time_s", key}, node);
    std::vector<TimedValue> values;
    for (const Node &entry : node.items) {
        const double time = read_time(list, entry);
        if (!values.empty() && time <= values.back().time_s) {
            fail(entry.origin, list + ".time_s", fmt::format("{}", time), "does not rise",
                 fmt::format("more than {} s", values.back().time_s));
        }
        values.push_back({time, needed_number(list, entry, key, -largest, largest, unit)});
    }
    return values;
}

void check_selection(const std::string &selection, const Origin &origin)
{
    std::vector<std::string> names = list_names(FileKind::imperfection);
    std::vector<std::string> parts;
    std::size_t begin = 0;
    while (begin <= selection.size()) {
        const std::size_t end = std::min(selection.find('+', begin), selection.size());
        parts.push_back(selection.substr(begin, end - begin));
        begin = end + 1;
    }
    const std::string name = fmt::format("[accept.{}]", selection);
    names.insert(names.begin(), {ANY, IDEAL});
    for (const std::string &part : parts) {
        if (std::count(names.begin(), names.end(), part) == 0) {
            const std::string near = nearest(part, names);
            fail(origin, name, "",
                 near.empty() ? "no such imperfection set"
                              : fmt::format("no such imperfection set, did you mean {}?", near),
                 fmt::format("{}; several joined with '+'", fmt::join(names, ", ")));
        }
    }
    if (selection != ANY && selection_name(parts) != selection) {
        fail(origin, name, "", "is not how this selection is written",
             fmt::format("[accept.\"{}\"]", selection_name(parts)));
    }
}

void read_limit(const std::string &table, const std::string &metric, const Node &value,
                AcceptLimits &limits)
{
    const std::string name = fmt::format("{}.{}", table, metric);
    if (metric == LOCKED) {
        if (value.kind != Node::Kind::boolean || !value.boolean) {
            fail(value.origin, name, shown(value), "is no limit", "true");
        }
        limits.must_lock = true;
        return;
    }
    if (std::count(METRICS.begin(), METRICS.end(), metric) == 0) {
        const std::string near = nearest(metric, METRICS);
        const bool found = !near.empty();
        fail(value.origin, name, shown(value),
             found ? fmt::format("unknown metric, did you mean {}?", near) : "unknown metric",
             found ? "" : fmt::format("{}, {}", LOCKED, fmt::join(METRICS, ", ")));
    }
    constexpr double largest = 1e6;
    check_number(name, value, 0, largest, range_text(0, largest, ""));
    limits.upper[metric] = value.number();
}

void read_accept(const Node &accept, std::map<std::string, AcceptLimits> &all)
{
    for (const auto &[selection, limits] : accept.members) {
        const std::string table = "accept." + selection;
        if (limits.kind != Node::Kind::table) {
            fail(limits.origin, table, shown(limits), std::string("is ") + kind_name(limits),
                 "a table of limits");
        }
        check_selection(selection, limits.origin);
        for (const auto &[metric, value] : limits.members) {
            read_limit(table, metric, value, all[selection]);
        }
    }
}

void read_extra(const Layer &layer, ScenarioSettings &scenario)
{
    const TimedKey &command = scenario.mode == DriveMode::speed ? SPEED : POSITION;
    for (const auto &[name, node] : layer.extra) {
        if (name == "accept") {
            read_accept(node, scenario.accept);
        } else if (name == "load") {
            scenario.load = read_list("scenario.load", TORQUE, node);
        } else if (name == "fault") {
            scenario.faults = read_faults(node);
        } else if (name == "request") {
            scenario.requests = read_requests(node);
        } else {
            scenario.command = read_list("scenario.command", command, node);
        }
    }
}

} // namespace

const AcceptLimits *ScenarioSettings::limits(const std::string &selection) const
{
    auto found = accept.find(selection);
    if (found == accept.end()) {
        found = accept.find(ANY);
    }
    return found == accept.end() ? nullptr : &found->second;
}

std::string selection_name(const std::vector<std::string> &with)
{
    std::vector<std::string> names;
    names.reserve(with.size());
    for (const std::string &name : with) {
        names.push_back(std::filesystem::path(name).stem().string());
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    if (names.size() > 1) {
        names.erase(std::remove(names.begin(), names.end(), IDEAL), names.end());
    }
    return names.empty() ? IDEAL : fmt::format("{}", fmt::join(names, "+"));
}

const std::vector<std::string> &scenario_lists()
{
    static const std::vector<std::string> lists = {"command", "load", "fault", "request"};
    return lists;
}

void check_scenario(const Layer &layer)
{
    if (layer.top.count("base") != 0) {
        return; // the mode may be the base's: apply_scenario() sees both
    }
    Config own;
    apply_layer(layer, own);
    read_extra(layer, own.scenario);
}

void apply_scenario(const Layer &layer, Config &config)
{
    read_extra(layer, config.scenario);
}

} // namespace nf
