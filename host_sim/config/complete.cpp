// SPDX-License-Identifier: MIT
#include "complete.h"

#include "plate.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf
{
namespace
{

// The required settings of the sections that a kind of file is there for, and that no layer has.
std::vector<const Field *> lacking_of(FileKind kind, const Config &config)
{
    std::vector<const Field *> lacking;
    for (const Field &field : schema()) {
        if (field.required && may_hold(kind, field.section) &&
            config.origins.count(field.name()) == 0) {
            lacking.push_back(&field);
        }
    }
    return lacking;
}

std::vector<std::string> names_of(const std::vector<const Field *> &fields)
{
    std::vector<std::string> names;
    names.reserve(fields.size());
    for (const Field *field : fields) {
        names.push_back(field->name());
    }
    return names;
}

// Whether a motor has none of what a name plate does not say; the friction, the last of it, counts
// neither way.
bool lacks_what_a_plate_lacks(const std::vector<const Field *> &lacking)
{
    const std::vector<std::string> names = names_of(lacking);
    const std::vector<std::string> &unknown = unknown_of_plate();
    return std::all_of(unknown.begin(), unknown.end() - 1, [&](const std::string &key) {
        return std::count(names.begin(), names.end(), key) != 0;
    });
}

bool is_unknown_of_plate(const Field &field)
{
    const std::vector<std::string> &unknown = unknown_of_plate();
    return std::count(unknown.begin(), unknown.end(), field.name()) != 0;
}

Origin table_of(const Layer &home, const std::string &section)
{
    const auto table = home.tables.find(section);
    return table == home.tables.end() ? Origin{home.file, 1} : table->second;
}

} // namespace

void check_complete(FileKind kind, const Layer &home, const Config &config)
{
    const std::vector<const Field *> lacking = lacking_of(kind, config);
    if (lacking.empty()) {
        return;
    }
    const Origin place = table_of(home, lacking.front()->section);
    const bool is_plate = kind == FileKind::motor && lacks_what_a_plate_lacks(lacking) &&
                          std::all_of(lacking.begin(), lacking.end(), [](const Field *field) {
                              return is_unknown_of_plate(*field);
                          });
    if (is_plate) {
        fail(
            place, fmt::format("{}", fmt::join(names_of(lacking), ", ")), "",
            "are missing: this is a name plate; `identify` in `motorsim live`, or `motorsim identify --records` of a console's log, measures them on a board",
            "");
    }
    refuse_missing(place, lacking);
}

void check_plate(const Layer &home, const Config &config)
{
    std::vector<const Field *> lacking = lacking_of(FileKind::motor, config);
    if (lacking.empty()) {
        return;
    }
    const Origin place = table_of(home, "motor");
    if (!lacks_what_a_plate_lacks(lacking)) {
        refuse_missing(place, lacking);
    }
    const std::string current = "motor.continuous_current_a";
    const auto written = config.origins.find(current);
    lacking.erase(std::remove_if(lacking.begin(), lacking.end(),
                                 [](const Field *field) { return is_unknown_of_plate(*field); }),
                  lacking.end());
    if (written == config.origins.end()) {
        lacking.push_back(find_field(current));
    }
    if (!lacking.empty()) {
        refuse_missing(place, lacking, ", and a name plate needs ");
    }
    if (config.motor.continuous_current_a <= 0) {
        fail(written->second, current, fmt::format("{}", config.motor.continuous_current_a),
             "is the current of rated torque, and a name plate does not say that torque",
             fmt::format("above 0, to {} A", find_field(current)->max));
    }
}

void forget_measured(Config &config)
{
    config.motor = plate_of(config.motor);
    if (config.origins.count("motor.rated_torque_nm") != 0) {
        config.origins.insert(
            {"motor.continuous_current_a", config.origins.at("motor.rated_torque_nm")});
    }
    config.measured = MeasuredSettings();
    for (const Field &field : schema()) {
        if (is_unknown_of_plate(field) || std::string(field.section) == "measured") {
            config.origins.erase(field.name());
        }
    }
}

} // namespace nf
