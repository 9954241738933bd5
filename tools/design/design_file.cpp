// SPDX-License-Identifier: MIT
#include "design_file.h"

#include "document.h"
#include "files.h"
#include "readable.h"
#include "schema.h"
#include "suggest.h"

#include <algorithm>
#include <map>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fs = std::filesystem;

namespace nf::design
{
namespace
{

using Place = std::variant<double *, int *>;

struct Key {
    const char *name; // "section.key"
    const char *unit;
    double min;
    double max;
    bool required;
    Place (*place)(DesignSettings &settings);
    const std::vector<std::string> *words; // of an int that is a choice
    const char *help;
};

const std::vector<std::string> STATE_WORDS = {"i_q", "i_d", "speed", "angle", "integral"};
const std::vector<std::string> INPUT_WORDS = {"load", "speed"};

#define PLACE(member) [](DesignSettings &s) -> Place { return &s.member; }

constexpr bool NEEDED = true;
constexpr bool OPTIONAL = false;
constexpr double KP_MAX = 1e3;
constexpr double KI_MAX = 1e6;

// clang-format off
const std::vector<Key> KEYS = {
    {"nominal.speed_rad_s", "rad/s", 0.1, 1e5, NEEDED, PLACE(nominal.speed_rad_s), nullptr, "electrical speed"},
    {"nominal.voltage_v", "V", 0.1, 1e4, NEEDED, PLACE(nominal.voltage_v), nullptr, "magnitude of the voltage"},
    {"nominal.torque_angle_deg", "°", -180, 180, NEEDED, PLACE(nominal.torque_angle_deg), nullptr, "torque angle δ0"},
    {"nominal.i_q_a", "A", -1e4, 1e4, NEEDED, PLACE(nominal.i_q_a), nullptr, "q current"},
    {"nominal.i_d_a", "A", -1e4, 1e4, NEEDED, PLACE(nominal.i_d_a), nullptr, "d current"},
    {"nominal.inertia_kg_m2", "kg·m²", 1e-7, 100, NEEDED, PLACE(nominal.inertia_kg_m2), nullptr, "J of (9), see linear_model.h"},
    {"nominal.voltage_per_speed_v_s_per_rad", "V·s/rad", 1e-6, 1e4, NEEDED, PLACE(nominal.voltage_per_speed_v_s_per_rad), nullptr, "K_b of (23)"},
    {"nominal.sample_time_s", "s", 1e-6, 1, NEEDED, PLACE(nominal.sample_time_s), nullptr, "period T of the speed controller"},
    {"nominal.k2", "", 0, 2, OPTIONAL, PLACE(nominal.k2), nullptr, "K_2 of (42), 1: the detector of the angle is true"},
    {"optimum.q1", "", 0, 1e9, OPTIONAL, PLACE(optimum.cost.q1), nullptr, "weight of X² in the cost (50)"},
    {"optimum.q2", "", 0, 1e9, OPTIONAL, PLACE(optimum.cost.q2), nullptr, "weight of the controller's output squared"},
    {"optimum.q3", "", 0, 1e9, OPTIONAL, PLACE(optimum.cost.q3), nullptr, "weight of X² at the horizon"},
    {"optimum.horizon_samples", "", 1, 1000, OPTIONAL, PLACE(optimum.cost.horizon_samples), nullptr, "samples that count"},
    {"optimum.state", "", 0, 0, OPTIONAL, PLACE(optimum.cost.state), &STATE_WORDS, "X of the cost"},
    {"optimum.input", "", 0, 0, OPTIONAL, PLACE(optimum.cost.input), &INPUT_WORDS, "where the unit step is"},
    {"optimum.slowest_time_constant_s", "s", 1e-4, 1e6, NEEDED, PLACE(optimum.slowest_time_constant_s), nullptr, "no mode of the closed loop may be slower"},
    {"start.kp", "", -KP_MAX, KP_MAX, NEEDED, PLACE(optimum.start.kp), nullptr, "K_p that the search starts from"},
    {"start.ki_per_s", "1/s", -KI_MAX, KI_MAX, NEEDED, PLACE(optimum.start.ki_per_s), nullptr, "K_i that the search starts from"},
    {"arbitrary.kp", "", -KP_MAX, KP_MAX, NEEDED, PLACE(arbitrary.kp), nullptr, "K_p of the figures 4a, 5a"},
    {"arbitrary.ki_per_s", "1/s", -KI_MAX, KI_MAX, NEEDED, PLACE(arbitrary.ki_per_s), nullptr, "K_i of the figures 4a, 5a"},
    {"published.kp", "", -KP_MAX, KP_MAX, NEEDED, PLACE(published.kp), nullptr, "K_p of the figures 4b, 5b, 6"},
    {"published.ki_per_s", "1/s", -KI_MAX, KI_MAX, NEEDED, PLACE(published.ki_per_s), nullptr, "K_i of the figures 4b, 5b, 6"},
    {"response.duration_s", "s", 1e-4, 1e4, OPTIONAL, PLACE(response_s), nullptr, "length of the step responses"},
};
// clang-format on
#undef PLACE

const std::vector<std::string> TOP = {"motor", "matrices"};

std::string allowed(const Key &key)
{
    if (key.words != nullptr) {
        return fmt::format("\"{}\"", fmt::join(*key.words, "\", \""));
    }
    DesignSettings any;
    const bool whole = std::holds_alternative<int *>(key.place(any));
    return (whole ? "a whole number, " : "") + range_text(key.min, key.max, key.unit);
}

std::vector<std::string> names()
{
    std::vector<std::string> known = TOP;
    for (const Key &key : KEYS) {
        known.emplace_back(key.name);
    }
    return known;
}

[[noreturn]] void unknown(const std::string &name, const Node &value)
{
    const std::string near = nearest(name, names());
    fail(value.origin, readable(name), shown(value),
         near.empty() ? "unknown key" : fmt::format("unknown key, did you mean {}?", near),
         near.empty() ? fmt::format("{}", fmt::join(names(), ", ")) : "");
}

void put_word(const Key &key, const Node &value, int &place)
{
    const auto found = std::find(key.words->begin(), key.words->end(), value.text);
    if (value.kind != Node::Kind::text || found == key.words->end()) {
        fail(value.origin, key.name, shown(value), "is no choice", allowed(key));
    }
    place = static_cast<int>(found - key.words->begin());
}

void put(const Key &key, const Node &value, DesignSettings &settings)
{
    const Place place = key.place(settings);
    if (key.words != nullptr) {
        put_word(key, value, *std::get<int *>(place));
        return;
    }
    check_number(key.name, value, key.min, key.max, allowed(key));
    if (const auto *whole = std::get_if<int *>(&place)) {
        if (value.kind != Node::Kind::integer) {
            fail(value.origin, key.name, shown(value), std::string("is ") + kind_name(value),
                 allowed(key));
        }
        **whole = static_cast<int>(value.integer);
    } else {
        *std::get<double *>(place) = value.number();
    }
}

using Values = std::map<std::string, Node>; // by "section.key"

Values flatten(const Node &document)
{
    Values values;
    for (const auto &[key, value] : document.members) {
        if (value.kind != Node::Kind::table) {
            values[key] = value;
            continue;
        }
        for (const auto &[name, member] : value.members) {
            values[fmt::format("{}.{}", key, name)] = member;
        }
    }
    return values;
}

// Overrides of the design itself; those of the motor are returned.
std::vector<std::string> override_values(const std::vector<std::string> &set, Values &values)
{
    std::vector<std::string> motor;
    for (const std::string &text : set) {
        const std::size_t equals = text.find('=');
        const std::string name = text.substr(0, equals);
        if (equals == std::string::npos || name.empty()) {
            fail({"--set", 0}, '"' + readable(text) + '"', "", "is no override",
                 "section.key=value");
        }
        if (name.rfind("motor.", 0) == 0) {
            motor.push_back(text);
        } else {
            values[name] = parse_override(name, text.substr(equals + 1));
        }
    }
    return motor;
}

std::string top_text(const Values &values, const std::string &key)
{
    const auto found = values.find(key);
    if (found == values.end()) {
        return "";
    }
    if (found->second.kind != Node::Kind::text) {
        fail(found->second.origin, key, shown(found->second),
             std::string("is ") + kind_name(found->second), "a string, the name or path of a file");
    }
    return found->second.text;
}

const fs::path DESIGNS = NF_DESIGNS_FOLDER;
const fs::path PUBLISHED = DESIGNS.parent_path() / "published";

void put_all(const Values &values, const std::string &file, DesignSettings &settings)
{
    for (const auto &[name, value] : values) {
        const std::vector<std::string> known = names();
        if (std::count(known.begin(), known.end(), name) == 0) {
            unknown(name, value);
        }
    }
    for (const Key &key : KEYS) {
        const auto found = values.find(key.name);
        if (found != values.end()) {
            put(key, found->second, settings);
        } else if (key.required) {
            fail({file, 1}, key.name, "", "is missing", allowed(key));
        }
    }
}

std::string default_text(const Key &key)
{
    if (key.required) {
        return "required";
    }
    DesignSettings untouched;
    const Place place = key.place(untouched);
    if (const auto *whole = std::get_if<int *>(&place)) {
        return key.words != nullptr
                   ? fmt::format("\"{}\"", (*key.words)[static_cast<std::size_t>(**whole)])
                   : fmt::format("{}", **whole);
    }
    return fmt::format("{}", *std::get<double *>(place));
}

} // namespace

DesignSettings read_design(const std::string &design, const std::vector<std::string> &set)
{
    const fs::path path = resolve_in(DESIGNS, design, "", "design", {"command line", 0});
    DesignSettings settings;
    settings.file = display_name(path);
    Values values = flatten(parse_document(settings.file, read_bytes(path)));
    const std::vector<std::string> motor_overrides = override_values(set, values);
    put_all(values, settings.file, settings);
    const std::string motor = top_text(values, "motor");
    if (motor.empty()) {
        fail({settings.file, 1}, "motor", "", "is missing", "the name or path of a motor file");
    }
    const bool written_here = values.at("motor").origin.file == settings.file;
    settings.foreign_nominal =
        !written_here && std::any_of(values.begin(), values.end(), [&](const auto &entry) {
            return entry.first.rfind("nominal.", 0) == 0 &&
                   entry.second.origin.file == settings.file;
        });
    const fs::path base = written_here ? path.parent_path() : "";
    settings.inputs = load_motor(is_path(motor) ? (base / motor).string() : motor, motor_overrides);
    const std::string matrices = top_text(values, "matrices");
    if (!matrices.empty()) {
        const Origin &named = values.at("matrices").origin;
        const fs::path from = named.file == settings.file ? path.parent_path() : "";
        settings.matrices = resolve_in(PUBLISHED, matrices, from, "matrices", named).string();
        settings.inputs.sources.read.emplace_back(settings.matrices);
    }
    settings.inputs.sources.read.push_back(path);
    return settings;
}

void check_gains(const Gains &gains, const std::string &place)
{
    const std::pair<const char *, double> values[] = {{"start.kp", gains.kp},
                                                      {"start.ki_per_s", gains.ki_per_s}};
    for (const auto &[name, number] : values) {
        const auto key =
            std::find_if(KEYS.begin(), KEYS.end(),
                         [wanted = std::string(name)](const Key &k) { return wanted == k.name; });
        Node value;
        value.kind = Node::Kind::real;
        value.real = number;
        value.origin = {place, 0};
        check_number(std::string(name).substr(6), value, key->min, key->max, allowed(*key));
    }
}

std::string key_list()
{
    std::string text;
    for (const Key &key : KEYS) {
        text += fmt::format("  {:<40}{:<50}{:<10} {}\n", key.name, allowed(key), default_text(key),
                            key.help);
    }
    return text;
}

const std::vector<std::string> &state_words()
{
    return STATE_WORDS;
}

const std::vector<std::string> &input_words()
{
    return INPUT_WORDS;
}

} // namespace nf::design
