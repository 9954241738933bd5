// SPDX-License-Identifier: MIT
#include "findings.h"

#include "bars.h"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf::identify
{
namespace
{

struct Row {
    const char *key; // of the motor file
    const char *title;
    const char *unit;
    double scale; // units of the table in one SI unit
    double value;
    double truth;
    double bar = 0;
};

std::vector<Row> rows_of(const Result &r, const Truth &t)
{
    const MotorSettings &v = r.motor;
    const MeasuredSettings &m = r.measured;
    constexpr double milli = 1e3;
    constexpr double nano = 1e9;
    std::vector<Row> rows = {
        {"resistance_ohm", "R", "ohm", 1, v.resistance_ohm, t.resistance_ohm},
        {"inductance_d_h", "L_d", "mH", milli, v.inductance_d_h, t.inductance_d_h},
        {"inductance_q_h", "L_q", "mH", milli, v.inductance_q_h, t.inductance_q_h},
        {"flux_linkage_wb", "flux linkage", "mWb", milli, v.flux_linkage_wb, t.flux_linkage_wb},
        {"inertia_kg_m2", "J", "kg m2", 1, v.inertia_kg_m2, t.inertia_kg_m2},
        {"viscous_friction_nm_s", "viscous friction", "N m s", 1, v.viscous_friction_nm_s,
         t.viscous_friction_nm_s},
    };
    for (Row &row : rows) {
        row.bar = bar_of(v, m, std::string("motor.") + row.key);
    }
    rows.push_back({"coulomb_friction_nm", "Coulomb friction", "N m", 1, m.coulomb_friction_nm,
                    t.coulomb_friction_nm, m.coulomb_friction_bar_nm});
    rows.push_back({"lost_time_s", "lost by a leg", "ns", nano, r.lost_time_s,
                    lost_time_s(t.dead_time_s, t.knee_a, t.current_a), r.lost_time_bar_s});
    return rows;
}

} // namespace

std::string table_text(const Result &result, const std::optional<Truth> &truth)
{
    std::string text = fmt::format("{:<18}{:>12}{:>12}  {:<6}{}\n", "", "measured", "bar", "",
                                   truth ? "        true       off" : "");
    for (const Row &row : rows_of(result, truth.value_or(Truth{}))) {
        text += fmt::format("{:<18}{:>12.4g}{:>12.2g}  {:<6}", row.title, row.value * row.scale,
                            row.bar * row.scale, row.unit);
        if (truth) {
            text += fmt::format("{:>12.4g}{:>10.2g}", row.truth * row.scale,
                                (row.value - row.truth) * row.scale);
        }
        text += '\n';
    }
    for (const std::string &remark : result.remarks) {
        text += remark + '\n';
    }
    return text;
}

std::string json_text(const Result &result, const std::optional<Truth> &truth, double duration_s)
{
    nlohmann::ordered_json json;
    for (const Row &row : rows_of(result, truth.value_or(Truth{}))) {
        nlohmann::ordered_json &entry = json[row.key];
        entry["value"] = row.value;
        entry["bar"] = row.bar;
        if (truth) {
            entry["truth"] = row.truth;
        }
    }
    json["flux_turning_wb"] = result.flux.turning_wb.value;
    if (result.flux.has_coasted) {
        json["flux_coasting_wb"] = result.flux.coasting_wb.value;
    }
    json["duration_s"] = duration_s;
    json["remarks"] = result.remarks;
    return json.dump(2) + '\n';
}

} // namespace nf::identify
