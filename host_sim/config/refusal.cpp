#include "refusal.h"

#include "numbers.h"
#include "schema.h"

#include <algorithm>
#include <cmath>

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

// What to write in place of a value of a file that serves every drive: `limit` is "at most 880 rpm".
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
        for (const char *from : {"plant.", "board."}) {
            const std::string name = from + key.substr(model.size());
            if (config.origins.count(name) != 0) {
                return name;
            }
        }
    }
    return key;
}

// The limit with four digits, rounded to where it is still allowed.
std::string limit_text(const SettingError &error)
{
    const auto &[at_most, value] = error.limit;
    const double digit = std::pow(10.0, std::floor(std::log10(value)) - 3);
    const double rounded = (at_most ? std::floor(value / digit) : std::ceil(value / digit)) * digit;
    return with_unit(fmt::format("at {} {:.10g}", at_most ? "most" : "least", rounded),
                     *find_field(error.key));
}

drive_cfg_t drive_of(const Config &config)
{
    return make_drive_cfg(config.motor, config.board, config.tuning, config.model);
}

// By what share of it the limit is another one in another configuration; a limit that is gone moved without end.
double limit_moved(const Config &other, const SettingError &error)
{
    try {
        drive_of(other);
    } catch (const SettingError &changed) {
        const double limit = error.limit.value;
        return std::string(changed.key) == error.key
                   ? std::abs(changed.limit.value - limit) / std::abs(limit)
                   : 0;
    }
    return HUGE_VAL;
}

constexpr double SHARE = 0.01; // by which a key is moved to see what it does

// How much a key moves the limit. Where a base steps from one power of two to the next, one way only does.
double weight_of(const Field &field, const Config &config, const SettingError &error)
{
    double weight = HUGE_VAL;
    for (const double factor : {1 - SHARE, 1 + SHARE}) {
        Config other = config;
        *place_of(field, other) *= factor;
        weight = std::min(weight, limit_moved(other, error));
    }
    return weight;
}

struct Culprit {
    const Field *field = nullptr;
    Author author{};
    double weight = 0;
};

// Whether the user chose `other` rather than `culprit`, or it moves the limit more; of equals the later one: a motor's
// inertia is easier to change than its flux.
bool is_rather(const Culprit &other, const Culprit &culprit)
{
    constexpr double EQUAL = 0.9;
    return other.author == culprit.author ? other.weight >= EQUAL * culprit.weight
                                          : other.author > culprit.author;
}

// Of the keys that were chosen for this drive rather than `author`'s, the one to blame. Null where none moves the limit.
const Field *culprit_of(const Config &config, const SettingError &error, Author author)
{
    constexpr double LEAST = SHARE / 4; // what the fourth root of a key does
    Culprit culprit;
    for (const Field &field : schema()) {
        Config copy = config;
        const auto origin = config.origins.find(field.name());
        if (origin == config.origins.end() || origin->second.author <= author ||
            place_of(field, copy) == nullptr) {
            continue;
        }
        const Culprit other = {&field, origin->second.author, weight_of(field, config, error)};
        if (other.weight > LEAST && (culprit.field == nullptr || is_rather(other, culprit))) {
            culprit = other;
        }
    }
    return culprit.field;
}

[[noreturn]] void refuse_as_written(const Config &config, const SettingError &error,
                                    const std::string &key)
{
    const auto found = config.origins.find(key);
    const std::string allowed = fmt::format("{}: {}", limit_text(error), error.reason);
    if (found == config.origins.end()) {
        fail({config.sources.tuning, 0}, key, "", "its default does not fit the firmware", allowed);
    }
    fail(found->second, key, fmt::format("{}", error.value), "does not fit the firmware", allowed);
}

} // namespace

void check_orders(const Config &config)
{
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
    const std::string key = written_key(config, error.key);
    const auto found = config.origins.find(key);
    const bool is_default = found == config.origins.end();
    const Author author = is_default ? Author::tuning : found->second.author;
    const Field *culprit = culprit_of(config, error, author);
    if (culprit == nullptr) {
        refuse_as_written(config, error, key);
    }
    fail(config.origins.at(culprit->name()), culprit->name(), culprit->number_text(config),
         fmt::format("{} = {} ({}) does not fit the firmware with it", key, error.value,
                     is_default ? "its default" : found->second.text()),
         fmt::format("{}: {}", instead(*find_field(key), limit_text(error)), error.reason));
}

} // namespace nf
