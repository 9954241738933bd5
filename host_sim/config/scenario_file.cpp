// SPDX-License-Identifier: MIT
#include "scenario_file.h"

#include "event_file.h"
#include "files.h"
#include "readable.h"
#include "si.h"
#include "suggest.h"
#include "timed_list.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf
{
namespace
{

// Metrics that a scenario may limit: numbers, and those that are good when they are true, or false.
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
                                          "angle_error_rms_deg",
                                          "speed_error_command_pct",
                                          "speed_error_load_pct",
                                          "torque_error_settled_pct",
                                          "saturation_internal_count"};
const std::map<std::string, bool> FLAGS = {
    {"locked", true}, {"limit_cycle", false}, {"reached", true}};
const std::string ANY = "any";
const std::string IDEAL = "ideal";
const std::string INHERIT_LIMITS = "scenario.inherit_limits";

std::string list_name(const std::string &list)
{
    return "scenario." + list;
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
    const std::string name = fmt::format("[accept.{}]", readable(selection));
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
             fmt::format("[accept.\"{}\"]", readable(selection_name(parts))));
    }
}

std::vector<std::string> names_of(const std::map<std::string, bool> &flags)
{
    std::vector<std::string> names;
    names.reserve(flags.size());
    for (const auto &[name, good] : flags) {
        names.push_back(name);
    }
    return names;
}

void read_limit(const std::string &table, const std::string &metric, const Node &value,
                AcceptLimits &limits)
{
    const std::string name = fmt::format("{}.{}", table, metric);
    const auto flag = FLAGS.find(metric);
    if (flag != FLAGS.end()) {
        if (value.kind != Node::Kind::boolean || value.boolean != flag->second) {
            fail(value.origin, name, shown(value), "is no limit", flag->second ? "true" : "false");
        }
        limits.flags.insert(*flag);
        return;
    }
    if (std::count(METRICS.begin(), METRICS.end(), metric) == 0) {
        const std::string near = nearest(metric, METRICS);
        const bool found = !near.empty();
        fail(value.origin, name, shown(value),
             found ? fmt::format("unknown metric, did you mean {}?", near) : "unknown metric",
             found ? ""
                   : fmt::format("{}, {}", fmt::join(names_of(FLAGS), ", "),
                                 fmt::join(METRICS, ", ")));
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

// Whether the limits that were stated before this layer do not count.
bool drops_limits(const Layer &layer)
{
    return std::any_of(layer.settings.begin(), layer.settings.end(), [](const Setting &setting) {
        return setting.field->name() == INHERIT_LIMITS && !setting.value.boolean;
    });
}

// `replaced`: a later layer has commands of its own.
void read_extra(const Layer &layer, const MotorSettings &motor, ScenarioSettings &scenario,
                bool replaced = false)
{
    if (drops_limits(layer)) {
        scenario.accept.clear();
    }
    for (const auto &[name, node] : layer.extra) {
        if (name == "accept") {
            read_accept(node, scenario.accept);
        } else if (name == "load") {
            scenario.load = read_loads(node, motor);
        } else if (name == "fault") {
            scenario.faults = read_faults(node);
        } else if (name == "request") {
            scenario.requests = read_requests(node);
        } else if (!replaced) {
            scenario.command = read_commands(node, scenario.mode, motor);
        }
    }
}

const char *const MODE = "scenario.mode";

const Setting *mode_of(const Layer &layer)
{
    for (const Setting &setting : layer.settings) {
        if (setting.field->name() == MODE) {
            return &setting;
        }
    }
    return nullptr;
}

// The commands of a base are of its mode: a layer that states another one brings its own.
void check_mode(const std::vector<const Layer *> &layers, std::size_t commands)
{
    const Setting *before = nullptr; // NULL: that of the default
    for (std::size_t k = 0; k < layers.size(); k++) {
        const Setting *const mode = mode_of(*layers[k]);
        const std::string had = before == nullptr ? "speed" : before->value.text;
        if (mode != nullptr && k > commands && mode->value.text != had) {
            const Node &list = layers[commands]->extra.at("command");
            fail(mode->value.origin, MODE, shown(mode->value),
                 fmt::format("the commands are of the mode \"{}\" ({})", had, list.origin.text()),
                 "that mode, or a list scenario.command of its own");
        }
        before = mode == nullptr ? before : mode;
    }
}

// "KEY = VALUE UNIT (FILE:LINE)" of a setting that a file states.
std::string stated(const std::string &key, double value, const std::string &unit,
                   const Config &config)
{
    return fmt::format("{} = {} {} ({})", key, value, unit, config.origins.at(key).text());
}

// What is to happen at the end or later never does. A run with a fault or request is made for it;
// steps of command and load are also those of a scenario that was cut short.
void check_in_time(const std::string &list, const Node &node, Config &config)
{
    const double half_a_tick_s = 0.5 / config.board.pwm_frequency_hz;
    for (const Node &entry : node.items) {
        const Node &time = *member(entry, "time_s");
        if (time.number() + half_a_tick_s < config.scenario.duration_s) {
            continue;
        }
        const std::string end =
            stated("scenario.duration_s", config.scenario.duration_s, "s", config);
        const std::string name = list_name(list) + ".time_s";
        if (list == "fault" || list == "request") {
            fail(time.origin, name, shown(time), "is not before the end of the run",
                 "less than " + end);
        }
        config.scenario.notes.push_back(
            fmt::format("{}: {} = {}: never acts, the run ends before: {}", time.origin.text(),
                        name, shown(time), end));
    }
}

// The drive limits a speed command to the motor's.
void note_clamped(const Node &command, Config &config)
{
    const MotorSettings &motor = config.motor;
    for (std::size_t k = 0; k < command.items.size(); k++) {
        if (config.scenario.mode != DriveMode::speed ||
            std::abs(config.scenario.command[k].value) <= motor.max_speed_rpm) {
            continue;
        }
        const EntryValue &choice = speed_value(command.items[k]);
        const Node &value = *member(command.items[k], choice.key);
        const std::string share =
            choice.rated == nullptr
                ? ""
                : fmt::format(", {:.4g} % of motor.rated_speed_rpm",
                              motor.max_speed_rpm / motor.rated_speed_rpm / PER_CENT);
        config.scenario.notes.push_back(
            fmt::format("{}: {} = {}: the drive turns no faster than {}{}", value.origin.text(),
                        choice.name(), shown(value),
                        stated("motor.max_speed_rpm", motor.max_speed_rpm, "rpm", config), share));
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
    read_extra(layer, own.motor, own.scenario);
}

void apply_scenario(const std::vector<const Layer *> &layers, Config &config)
{
    std::map<std::string, const Node *> lists; // those in force
    std::size_t commands = layers.size();
    for (std::size_t k = 0; k < layers.size(); k++) {
        commands = layers[k]->extra.count("command") != 0 ? k : commands;
    }
    check_mode(layers, commands);
    for (std::size_t k = 0; k < layers.size(); k++) {
        const Layer *const layer = layers[k];
        read_extra(*layer, config.motor, config.scenario, k < commands);
        for (const auto &[name, node] : layer->extra) {
            lists[name] = &node;
        }
    }
    lists.erase("accept");
    if (config.origins.count("scenario.duration_s") == 0) {
        return; // parts alone, without a run
    }
    for (const auto &[name, list] : lists) {
        check_in_time(name, *list, config);
    }
    if (lists.count("command") != 0) {
        note_clamped(*lists["command"], config);
    }
}

} // namespace nf
