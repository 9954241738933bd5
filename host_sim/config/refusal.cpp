// SPDX-License-Identifier: MIT
#include "refusal.h"

#include "limit.h"
#include "per_unit.h"
#include "rules.h"
#include "schema.h"
#include "setting_error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>

namespace nf
{
namespace
{

// Two settings of which the first may not exceed the second.
struct Order {
    const char *smaller;
    const char *larger;
};
constexpr Order ORDERS[] = {
    {"board.bus_min_v", "board.bus_nominal_v"},
    {"board.bus_nominal_v", "board.bus_max_v"},
    {"board.bus_max_v", "board.bus_full_scale_v"},
    {"board.overcurrent_a", "board.current_full_scale_a"},
    {"motor.max_current_a", "board.overcurrent_a"},
    {"position_loop.speed_rpm", "motor.max_speed_rpm"},
    {"scenario.evaluate_from_s", "scenario.duration_s"},
};

// Null where it is no real number.
double *place_of(const Field &field, Config &config)
{
    const Target target = field.target(config);
    const auto *place = std::get_if<double *>(&target);
    return place == nullptr ? nullptr : *place;
}

double value_of(const Field &field, const Config &config)
{
    Config copy = config;
    return *place_of(field, copy);
}

std::string with_unit(const std::string &number, const Field &field)
{
    return number + (*field.unit == '\0' ? "" : " ") + field.unit;
}

// What to write in place of a value of a file that serves every drive: `limit` is "at most 880
// rpm".
std::string instead(const Field &field, const std::string &limit)
{
    const bool is_tuned = may_hold(FileKind::tuning, field.section);
    const bool has_rule = rule_source(field.name(), TuningSettings()) != nullptr;
    return fmt::format("write {} in a {} of your own or with --set, {}{}", field.name(),
                       is_tuned ? "scenario or tuning" : "file", limit,
                       has_rule ? ", or 0, which leaves it to the motor" : "");
}

void check_order(const Config &config, const Field &smaller, const Field &larger)
{
    const Origin &low = config.origins.at(smaller.name());
    const Origin &high = config.origins.at(larger.name());
    const std::string least = fmt::format("{}", value_of(smaller, config));
    const std::string most = fmt::format("{}", value_of(larger, config));
    const std::string at_most = "at most " + with_unit(most, larger);
    if (value_of(smaller, config) <= value_of(larger, config)) {
        return;
    }
    if (high.author > low.author) {
        fail(high, larger.name(), most, "is too small",
             fmt::format("at least {}, which is {} ({}); or {}", with_unit(least, smaller),
                         smaller.name(), low.text(), instead(smaller, at_most)));
    }
    fail(low, smaller.name(), least, "is too large",
         fmt::format("{}, which is {} ({})", at_most, larger.name(), high.text()));
}

// The key in a file that a value of the model is from.
std::string written_key(const Config &config, const std::string &key)
{
    const std::string model = "model.";
    if (key.rfind(model, 0) == 0 && config.origins.count(key) == 0) {
        for (const char *from : {"measured.", "plant.", "board."}) {
            const std::string name = from + key.substr(model.size());
            if (config.origins.count(name) != 0) {
                return name;
            }
        }
    }
    return key;
}

std::string limit_text(const SettingError &error)
{
    return with_unit(
        fmt::format("at {} {}", error.limit.at_most ? "most" : "least", limit_number(error.limit)),
        *find_field(error.key));
}

// What keeps a configuration from being the firmware's, after all that limits the same key.
struct Misfit {
    SettingError error;
    bool is_hopeless; // no value of the key fits the others
};

std::optional<SettingError> error_of(const Config &config)
{
    try {
        make_drive_cfg(config.motor, config.board, config.tuning, config.model);
    } catch (const SettingError &error) {
        return error;
    }
    return {};
}

// A number of a configuration that is tried with other values, and has its own again at the end.
class Tried
{
public:
    explicit Tried(double *place) : place_(place), own_(place == nullptr ? 0 : *place)
    {
    }
    Tried(const Tried &) = delete;
    Tried &operator=(const Tried &) = delete;
    ~Tried()
    {
        if (place_ != nullptr) {
            *place_ = own_;
        }
    }

    bool is_number() const
    {
        return place_ != nullptr;
    }
    double own() const
    {
        return own_;
    }
    void put(double value)
    {
        *place_ = value;
    }

private:
    double *place_;
    double own_;
};

// One limit may lie behind another: the key is put on each until it is no longer refused.
Misfit last_limit(Config &config, SettingError error)
{
    const Field &field = *find_field(error.key);
    const auto is_allowed = [&](double limit) { return limit >= field.min && limit <= field.max; };
    Tried tried(place_of(field, config));
    while (tried.is_number() && is_allowed(rounded(error.limit))) {
        tried.put(rounded(error.limit));
        const std::optional<SettingError> next = error_of(config);
        if (!next || next->key != error.key) {
            return {error, false};
        }
        const bool is_further = error.limit.at_most ? next->limit.value < error.limit.value
                                                    : next->limit.value > error.limit.value;
        if (next->limit.at_most != error.limit.at_most || !is_further) {
            return {error, true};
        }
        error.limit = next->limit;
        error.reason = next->reason;
    }
    return {error, tried.is_number()};
}

// By what share of it the limit is another one after `moved` was; a limit that is gone, or gives
// way to one of that key's own, moved without end.
double limit_moved(Config &config, const SettingError &error, const Field &moved)
{
    const std::optional<SettingError> found = error_of(config);
    if (!found || found->key == moved.name()) {
        return HUGE_VAL;
    }
    if (found->key != error.key) {
        return 0;
    }
    const double change =
        std::abs(last_limit(config, *found).error.limit.value - error.limit.value);
    return change > 0 ? change / std::abs(error.limit.value) : 0;
}

constexpr double SHARE = 0.01; // by which a key is moved to see what it does

// How much a key moves the limit, while it stays in its own range. Where a base steps from one
// power of two to the next, one way only does.
double weight_of(const Field &field, Config &config, const SettingError &error)
{
    double weight = HUGE_VAL;
    Tried tried(place_of(field, config));
    for (const double factor : {1 - SHARE, 1 + SHARE}) {
        const double moved = tried.own() * factor;
        if (moved >= field.min && moved <= field.max) {
            tried.put(moved);
            weight = std::min(weight, limit_moved(config, error, field));
        }
    }
    return weight;
}

struct Culprit {
    const Field *field = nullptr;
    Author author{};
    double weight = 0;
};

// Whether the user chose `other` rather than `culprit`, or it moves the limit more; of equals the
// later one: a motor's inertia is easier to change than its flux.
bool is_rather(const Culprit &other, const Culprit &culprit)
{
    constexpr double EQUAL = 0.9;
    return other.author == culprit.author ? other.weight >= EQUAL * culprit.weight
                                          : other.author > culprit.author;
}

// Of the keys beside the refused one that `may_be` lets be blamed, the one to blame. Null where
// none moves the limit.
const Field *culprit_of(Config &config, const SettingError &error,
                        const std::function<bool(Author)> &may_be)
{
    constexpr double LEAST = SHARE / 4; // what the fourth root of a key does
    Culprit culprit;
    for (const Field &field : schema()) {
        const auto origin = config.origins.find(field.name());
        if (origin == config.origins.end() || !may_be(origin->second.author) ||
            field.name() == error.key || place_of(field, config) == nullptr) {
            continue;
        }
        const Culprit other = {&field, origin->second.author, weight_of(field, config, error)};
        if (other.weight > LEAST && (culprit.field == nullptr || is_rather(other, culprit))) {
            culprit = other;
        }
    }
    return culprit.field;
}

// Of a key that no file writes: the file that may.
Origin home_of(const Config &config, const Field &field)
{
    for (const FileKind kind : {FileKind::motor, FileKind::board}) {
        if (may_hold(kind, field.section)) {
            return {config.origins.at(std::string(kind_name(kind)) + ".name").file, 0};
        }
    }
    return {config.origins.at("tuning.name").file, 0};
}

[[noreturn]] void refuse_as_written(const Config &config, const Misfit &misfit,
                                    const std::string &key)
{
    const SettingError &error = misfit.error;
    const auto found = config.origins.find(key);
    const bool is_default = found == config.origins.end();
    fail(is_default ? home_of(config, *find_field(key)) : found->second, key,
         fmt::format("{}", error.value),
         is_default ? "its default does not fit the firmware" : "does not fit the firmware",
         fmt::format("{}: {}", misfit.is_hopeless ? "another motor or board" : limit_text(error),
                     error.reason));
}

// When to act on a high bus follows from its capacitor.
void check_safe_state(const Config &config)
{
    if (config.board.safe_state != SafeState::open &&
        config.origins.count("board.bus_capacitance_f") == 0) {
        fail(config.origins.at("board.safe_state"), "board.safe_state", "\"short\"",
             "board.bus_capacitance_f is not written", "\"open\", or \"short\" with it");
    }
}

} // namespace

void check_orders(const Config &config)
{
    check_safe_state(config);
    for (const Order &order : ORDERS) {
        if (config.origins.count(order.smaller) != 0 && config.origins.count(order.larger) != 0) {
            check_order(config, *find_field(order.smaller), *find_field(order.larger));
        }
    }
}

void refuse(const Config &config, const SettingError &error)
{
    if (const char *from = rule_source(error.key, config.tuning)) {
        fail(config.origins.at(from), from, find_field(from)->number_text(config),
             std::string(error.key) + " follows from it by rule and does not fit the firmware",
             std::string("another motor, or write ") + error.key);
    }
    Config trial = config;
    const Misfit misfit = last_limit(trial, error);
    const std::string key = written_key(config, error.key);
    const auto found = config.origins.find(key);
    const bool is_default = found == config.origins.end();
    const Field *culprit = culprit_of(trial, misfit.error, [&](Author author) {
        return misfit.is_hopeless || is_default || author > found->second.author;
    });
    if (culprit == nullptr) {
        refuse_as_written(config, misfit, key);
    }
    const std::string name = culprit->name();
    const std::string allowed =
        misfit.is_hopeless ? fmt::format("another {}, as no {} goes with this one", name, key)
                           : instead(*find_field(key), limit_text(misfit.error));
    fail(config.origins.at(name), name, culprit->number_text(config),
         fmt::format("{} = {} ({}) does not fit the firmware with it", key, error.value,
                     is_default ? "its default" : found->second.text()),
         fmt::format("{}: {}", allowed, misfit.error.reason));
}

} // namespace nf
