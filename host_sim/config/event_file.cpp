// SPDX-License-Identifier: MIT
#include "event_file.h"

#include "readable.h"
#include "schema.h"
#include "suggest.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

const std::string FAULT = "scenario.fault";
const std::string REQUEST = "scenario.request";
constexpr double TIME_MAX_S = 3600;
constexpr double CONFIG_BYTES = sizeof(drive_cfg_t);

enum class Value {
    none,
    optional,
    needed,
    whole // and needed
};

struct Word {
    const char *what;
    FaultKind kind;
    Value value;
    double min;
    double max;
    const char *unit;
    FaultSpan span;
};

// clang-format off
constexpr Word WORDS[] = {
    {"adc_a_stuck", FaultKind::adc_a_stuck, Value::optional, -2000, 2000, "A", FaultSpan::lasting},
    {"adc_a_high", FaultKind::adc_a_high, Value::none, 0, 0, "", FaultSpan::lasting},
    {"adc_a_low", FaultKind::adc_a_low, Value::none, 0, 0, "", FaultSpan::lasting},
    {"adc_b_stuck", FaultKind::adc_b_stuck, Value::optional, -2000, 2000, "A", FaultSpan::lasting},
    {"adc_b_high", FaultKind::adc_b_high, Value::none, 0, 0, "", FaultSpan::lasting},
    {"adc_b_low", FaultKind::adc_b_low, Value::none, 0, 0, "", FaultSpan::lasting},
    {"adc_bus_stuck", FaultKind::adc_bus_stuck, Value::optional, 0, 2000, "V", FaultSpan::lasting},
    {"adc_a_gain", FaultKind::adc_a_gain, Value::needed, 0, 10, "", FaultSpan::lasting},
    {"adc_b_gain", FaultKind::adc_b_gain, Value::needed, 0, 10, "", FaultSpan::lasting},
    {"adc_c_gain", FaultKind::adc_c_gain, Value::needed, 0, 10, "", FaultSpan::lasting},
    {"adc_all_gain", FaultKind::adc_all_gain, Value::needed, 0, 10, "", FaultSpan::lasting},
    {"adc_bus_gain", FaultKind::adc_bus_gain, Value::needed, 0, 10, "", FaultSpan::lasting},
    {"temperature_high", FaultKind::temperature_high, Value::none, 0, 0, "", FaultSpan::lasting},
    {"temperature_low", FaultKind::temperature_low, Value::none, 0, 0, "", FaultSpan::lasting},
    {"duty_a_stuck", FaultKind::duty_a_stuck, Value::optional, 0, 100, "%", FaultSpan::lasting},
    {"duty_b_stuck", FaultKind::duty_b_stuck, Value::optional, 0, 100, "%", FaultSpan::lasting},
    {"duty_c_stuck", FaultKind::duty_c_stuck, Value::optional, 0, 100, "%", FaultSpan::lasting},
    {"clock", FaultKind::clock, Value::needed, 0.5, 2, "", FaultSpan::lasting},
    {"angle_stuck", FaultKind::angle_stuck, Value::none, 0, 0, "", FaultSpan::lasting},
    {"angle_offset", FaultKind::angle_offset, Value::needed, -360, 360, "°", FaultSpan::lasting},
    {"sensor_high", FaultKind::sensor_high, Value::whole, 1, 65535, "", FaultSpan::lasting},
    {"sensor_low", FaultKind::sensor_low, Value::whole, 1, 65535, "", FaultSpan::lasting},
    {"sensor_flipped", FaultKind::sensor_flipped, Value::whole, 1, 65535, "", FaultSpan::tick},
    {"encoder_slip", FaultKind::encoder_slip, Value::whole, -32768, 32767, "", FaultSpan::lasting},
    {"overcurrent", FaultKind::overcurrent, Value::needed, -2000, 2000, "A", FaultSpan::tick},
    {"phase_a_open", FaultKind::phase_a_open, Value::none, 0, 0, "", FaultSpan::lasting},
    {"phase_b_open", FaultKind::phase_b_open, Value::none, 0, 0, "", FaultSpan::lasting},
    {"phase_c_open", FaultKind::phase_c_open, Value::none, 0, 0, "", FaultSpan::lasting},
    {"bus_voltage", FaultKind::bus_voltage, Value::needed, 0.001, 2000, "V", FaultSpan::lasting},
    {"temperature", FaultKind::temperature, Value::needed, -250, 250, "°C", FaultSpan::lasting},
    {"rotor_blocked", FaultKind::rotor_blocked, Value::none, 0, 0, "", FaultSpan::lasting},
    {"rotor_jump", FaultKind::rotor_jump, Value::needed, -360, 360, "°", FaultSpan::instant},
    {"break_input", FaultKind::break_input, Value::none, 0, 0, "", FaultSpan::tick},
    {"late_isr", FaultKind::late_isr, Value::none, 0, 0, "", FaultSpan::tick},
    {"config_corrupt", FaultKind::config_corrupt, Value::whole, 0, CONFIG_BYTES - 1, "", FaultSpan::instant},
};
// clang-format on

const Word &read_word(const Node &entry)
{
    std::vector<std::string> known;
    for (const Word &word : WORDS) {
        known.emplace_back(word.what);
    }
    const Node *what = member(entry, "what");
    const std::string name = FAULT + ".what";
    const std::string all = fmt::format("{}", fmt::join(known, ", "));
    if (what == nullptr) {
        fail(entry.origin, name, "", "is missing", all);
    }
    if (what->kind != Node::Kind::text) {
        fail(what->origin, name, shown(*what), std::string("is ") + kind_name(*what), all);
    }
    const auto found = std::find(known.begin(), known.end(), what->text);
    if (found == known.end()) {
        const std::string near = nearest(what->text, known);
        fail(what->origin, name, shown(*what),
             near.empty() ? "unknown fault" : fmt::format("unknown fault, did you mean {}?", near),
             near.empty() ? all : "");
    }
    return WORDS[found - known.begin()];
}

std::optional<double> read_value(const Node &entry, const Word &word)
{
    const std::string name = FAULT + ".value";
    const Node *value = member(entry, "value");
    const bool may_lack = word.value == Value::none || word.value == Value::optional;
    if (value == nullptr && may_lack) {
        return std::nullopt;
    }
    if (word.value == Value::none) {
        fail(value->origin, name, shown(*value), fmt::format("{} takes no value", word.what), "");
    }
    if (word.value == Value::whole && value != nullptr && !value->whole()) {
        fail(value->origin, name, shown(*value), std::string("is ") + kind_name(*value),
             "a whole number, " + range_text(word.min, word.max, word.unit));
    }
    return needed_number(FAULT, entry, "value", word.min, word.max, word.unit);
}

std::optional<double> read_until(const Node &entry, const Word &word, double time_s)
{
    const std::string name = FAULT + ".until_s";
    const Node *until = member(entry, "until_s");
    if (until == nullptr) {
        return std::nullopt;
    }
    if (word.span == FaultSpan::instant) {
        fail(until->origin, name, shown(*until), fmt::format("{} does not last", word.what), "");
    }
    const double end_s = needed_number(FAULT, entry, "until_s", -TIME_MAX_S, TIME_MAX_S, "s");
    if (end_s <= time_s) {
        fail(until->origin, name, shown(*until), "is too small",
             fmt::format("more than {} s, which is {}.time_s", time_s, FAULT));
    }
    return end_s;
}

bool read_flag(const Node &entry, const std::string &key, bool may_be_false)
{
    const Node &value = *member(entry, key);
    const std::string allowed = may_be_false ? "true or false" : "true";
    if (value.kind != Node::Kind::boolean) {
        fail(value.origin, REQUEST + '.' + key, shown(value), std::string("is ") + kind_name(value),
             allowed);
    }
    if (!value.boolean && !may_be_false) {
        fail(value.origin, REQUEST + '.' + key, shown(value), "asks for nothing", allowed);
    }
    return value.boolean;
}

} // namespace

const Node *member(const Node &entry, const std::string &key)
{
    const auto found = std::find_if(entry.members.begin(), entry.members.end(),
                                    [&](const auto &pair) { return pair.first == key; });
    return found == entry.members.end() ? nullptr : &found->second;
}

void check_list(const std::string &name, const std::vector<std::string> &keys, const Node &list)
{
    const std::string tables = fmt::format("tables [[{}]]", name);
    if (list.kind != Node::Kind::list) {
        fail(list.origin, name, shown(list), std::string("is ") + kind_name(list), tables);
    }
    for (const Node &entry : list.items) {
        if (entry.kind != Node::Kind::table) {
            fail(entry.origin, name, shown(entry), std::string("is ") + kind_name(entry), tables);
        }
        for (const auto &[key, value] : entry.members) {
            if (std::count(keys.begin(), keys.end(), key) == 0) {
                fail(value.origin, fmt::format("{}.{}", name, readable(key)), shown(value),
                     "unknown key", fmt::format("{}", fmt::join(keys, ", ")));
            }
        }
    }
}

double needed_number(const std::string &name, const Node &entry, const std::string &key, double min,
                     double max, const std::string &unit)
{
    const std::string full = fmt::format("{}.{}", name, key);
    const std::string allowed = range_text(min, max, unit);
    const Node *value = member(entry, key);
    if (value == nullptr) {
        fail(entry.origin, full, "", "is missing", allowed);
    }
    check_number(full, *value, min, max, allowed);
    return value->number();
}

double read_time(const std::string &name, const Node &entry)
{
    return needed_number(name, entry, "time_s", -TIME_MAX_S, TIME_MAX_S, "s");
}

std::vector<FaultEntry> read_faults(const Node &list)
{
    check_list(FAULT, {"time_s", "what", "value", "until_s"}, list);
    std::vector<FaultEntry> faults;
    for (const Node &entry : list.items) {
        const double time_s = read_time(FAULT, entry);
        const Word &word = read_word(entry);
        const std::optional<double> value = read_value(entry, word);
        faults.push_back({time_s, word.kind, word.span, value, read_until(entry, word, time_s)});
    }
    return faults;
}

std::vector<RequestEntry> read_requests(const Node &list)
{
    check_list(REQUEST, {"time_s", "run", "clear"}, list);
    std::vector<RequestEntry> requests;
    for (const Node &entry : list.items) {
        RequestEntry request{};
        request.time_s = read_time(REQUEST, entry);
        if (!requests.empty() && request.time_s <= requests.back().time_s) {
            fail(entry.origin, REQUEST + ".time_s", fmt::format("{}", request.time_s),
                 "does not rise", fmt::format("more than {} s", requests.back().time_s));
        }
        if (member(entry, "run") == nullptr && member(entry, "clear") == nullptr) {
            fail(entry.origin, REQUEST, "", "asks for nothing",
                 "run = true or false, clear = true");
        }
        request.clear = member(entry, "clear") != nullptr && read_flag(entry, "clear", false);
        if (member(entry, "run") != nullptr) {
            request.run = read_flag(entry, "run", true);
        }
        requests.push_back(request);
    }
    return requests;
}

} // namespace nf
