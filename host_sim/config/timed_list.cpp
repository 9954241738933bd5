// SPDX-License-Identifier: MIT
#include "timed_list.h"

#include "event_file.h"
#include "schema.h"
#include "si.h"

#include <fmt/format.h>

namespace nf
{
namespace
{

// The values that an entry of a list of timed values can hold: one of these, in SI or as a share.
using Choices = std::vector<EntryValue>;
const Choices SPEED = {
    {"command", "speed_rpm", "rpm", SPEED_COMMAND_MAX_RPM, nullptr, "commanded speed"},
    {"command", "speed_pct", "%", SPEED_COMMAND_MAX_PCT, &MotorSettings::rated_speed_rpm,
     "likewise, of motor.rated_speed_rpm"},
};
const Choices POSITION = {
    {"command", "position_rad", "rad", POSITION_COMMAND_MAX_RAD, nullptr,
     "commanded angle of the shaft, mode \"position\""},
};
const Choices TORQUE = {
    {"command", "torque_nm", "N·m", LOAD_MAX_NM, nullptr,
     "commanded torque, mode \"torque\", + drives forwards"},
    {"command", "torque_pct", "%", LOAD_MAX_PCT, &MotorSettings::rated_torque_nm,
     "likewise, of motor.rated_torque_nm"},
};
const Choices LOAD = {
    {"load", "torque_nm", "N·m", LOAD_MAX_NM, nullptr, "load, against a positive speed"},
    {"load", "torque_pct", "%", LOAD_MAX_PCT, &MotorSettings::rated_torque_nm,
     "likewise, of motor.rated_torque_nm"},
};

const Choices &commands_in(DriveMode mode)
{
    if (mode == DriveMode::position) {
        return POSITION;
    }
    return mode == DriveMode::torque ? TORQUE : SPEED;
}

std::vector<std::string> keys_of(const Choices &choices)
{
    std::vector<std::string> keys;
    keys.reserve(choices.size());
    for (const EntryValue &choice : choices) {
        keys.emplace_back(choice.key);
    }
    return keys;
}

// The one of the choices that an entry holds.
const EntryValue &chosen(const Choices &choices, const Node &entry)
{
    const EntryValue *found = nullptr;
    for (const EntryValue &choice : choices) {
        const Node *value = member(entry, choice.key);
        if (value != nullptr && found != nullptr) {
            fail(value->origin, choice.name(), shown(*value),
                 fmt::format("stands beside {}", found->key), "one of both");
        }
        found = value == nullptr ? found : &choice;
    }
    if (found == nullptr) {
        const EntryValue &first = choices.front();
        const std::string others =
            choices.size() > 1 ? fmt::format(", or {}", choices.back().key) : "";
        fail(entry.origin, first.name(), "", "is missing", first.allowed() + others);
    }
    return *found;
}

double read_value(const Choices &choices, const Node &entry, const MotorSettings &motor)
{
    const EntryValue &choice = chosen(choices, entry);
    const double value = needed_number("scenario." + std::string(choice.list), entry, choice.key,
                                       -choice.largest, choice.largest, choice.unit);
    return choice.rated == nullptr ? value : value * PER_CENT * motor.*choice.rated;
}

std::vector<TimedValue> read_list(const Choices &choices, const Node &node,
                                  const MotorSettings &motor)
{
    const std::string list = "scenario." + std::string(choices.front().list);
    std::vector<std::string> keys = keys_of(choices);
    keys.insert(keys.begin(), "time_s");
    check_list(list, keys, node);
    std::vector<TimedValue> values;
    for (const Node &entry : node.items) {
        const double time = read_time(list, entry);
        if (!values.empty() && time <= values.back().time_s) {
            fail(entry.origin, list + ".time_s", fmt::format("{}", time), "does not rise",
                 fmt::format("more than {} s", values.back().time_s));
        }
        values.push_back({time, read_value(choices, entry, motor)});
    }
    return values;
}

} // namespace

std::string EntryValue::name() const
{
    return fmt::format("scenario.{}.{}", list, key);
}

std::string EntryValue::allowed() const
{
    return range_text(-largest, largest, unit);
}

const std::vector<EntryValue> &entry_values()
{
    static const std::vector<EntryValue> all = [] {
        Choices values;
        for (const Choices *choices : {&SPEED, &POSITION, &TORQUE, &LOAD}) {
            values.insert(values.end(), choices->begin(), choices->end());
        }
        return values;
    }();
    return all;
}

std::vector<TimedValue> read_commands(const Node &list, DriveMode mode, const MotorSettings &motor)
{
    return read_list(commands_in(mode), list, motor);
}

std::vector<TimedValue> read_loads(const Node &list, const MotorSettings &motor)
{
    return read_list(LOAD, list, motor);
}

const EntryValue &speed_value(const Node &entry)
{
    return chosen(SPEED, entry);
}

} // namespace nf
