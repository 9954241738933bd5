// SPDX-License-Identifier: MIT
#include "findings.h"

#include "bars.h"
#include "numbers.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf::identify
{
namespace
{

struct Row {
    const char *key; // of the motor file
    std::string title;
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
    rows.push_back(
        {"knee_a", "knee of a leg", "A", 1, std::max(m.knee_a, 0.0), t.knee_a, r.knee_bar_a});
    rows.push_back({"gain_mismatch_pct", "gain a/b - 1", "%", 1, m.gain_mismatch_pct,
                    t.gain_mismatch_pct, m.gain_mismatch_bar_pct});
    rows.push_back({"current_noise_lsb", "noise", "LSB", 1, m.current_noise_lsb,
                    t.current_noise_lsb, r.noise_bar_lsb});
    return rows;
}

// An inductance over the current: a list in JSON, a row each in the table.
struct Curve {
    const char *key;
    const char *title;
    const std::vector<AtCurrent> &points;
    double (*truth)(const Truth &, double);
};

std::vector<Curve> curves_of(const Result &r)
{
    return {
        {"inductance_d_over_current", "L_d", r.inductances.d_over_current, inductance_d_h},
        {"inductance_q_over_current", "L_q", r.inductances.q_over_current, inductance_q_h},
    };
}

Finding finding_of(const Row &row)
{
    return {row.title, fmt::format("{:.4g}", row.value * row.scale),
            fmt::format("{:.2g}", row.bar * row.scale), row.unit};
}

std::string row_text(const Row &row, bool has_truth)
{
    const Finding found = finding_of(row);
    std::string text =
        fmt::format("{:<18}{:>12}{:>12}  {:<6}", found.title, found.value, found.bar, found.unit);
    if (has_truth) {
        text += fmt::format("{:>12.4g}{:>10.2g}", row.truth * row.scale,
                            (row.value - row.truth) * row.scale);
    }
    return text + '\n';
}

Row row_of(const Curve &curve, const AtCurrent &point, const Truth &truth)
{
    constexpr double milli = 1e3;
    return {"",
            fmt::format("{} at {:.3g} A", curve.title, point.current_a),
            "mH",
            milli,
            point.h.value,
            curve.truth(truth, point.current_a),
            error_bar(point.h.std, point.h.bound)};
}

// Each edge; its truth is the one on the same side of 0°.
std::vector<Row> hall_rows(const Halls &halls, const Truth &truth)
{
    std::vector<Row> rows;
    for (const HallEdge &edge : halls.edges) {
        const double off = std::remainder(
            edge.deg.value - truth.halls_deg.at(static_cast<std::size_t>(edge.pattern)), 360.0);
        rows.push_back({"", fmt::format("Hall {} from", edge.pattern), "deg", 1, edge.deg.value,
                        edge.deg.value - off, error_bar(edge.deg.std, edge.deg.bound)});
    }
    return rows;
}

std::vector<Row> rows_of_table(const Result &result, const Truth &truth)
{
    std::vector<Row> rows = rows_of(result, truth);
    for (const Curve &curve : curves_of(result)) {
        for (const AtCurrent &point : curve.points) {
            rows.push_back(row_of(curve, point, truth));
        }
    }
    if (result.halls.measured) {
        const std::vector<Row> edges = hall_rows(result.halls, truth);
        rows.insert(rows.end(), edges.begin(), edges.end());
    }
    return rows;
}

nlohmann::ordered_json curve_json(const Curve &curve, const std::optional<Truth> &truth)
{
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const AtCurrent &point : curve.points) {
        nlohmann::ordered_json entry;
        entry["current_a"] = point.current_a;
        entry["value"] = point.h.value;
        entry["bar"] = error_bar(point.h.std, point.h.bound);
        if (truth) {
            entry["truth"] = curve.truth(*truth, point.current_a);
        }
        list.push_back(entry);
    }
    return list;
}

nlohmann::ordered_json speeds_json(const Result &result)
{
    constexpr double rad_s_per_rpm = PI / 30;
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const FluxAtSpeed &point : result.flux.over_speed) {
        nlohmann::ordered_json entry;
        entry["speed_rpm"] = point.speed_el_rad_s / result.motor.pole_pairs / rad_s_per_rpm;
        entry["value"] = point.wb.value;
        entry["bar"] = error_bar(point.wb.std, point.wb.bound);
        list.push_back(entry);
    }
    return list;
}

nlohmann::ordered_json halls_json(const Halls &halls, const std::optional<Truth> &truth)
{
    nlohmann::ordered_json json;
    const std::vector<Row> rows = hall_rows(halls, truth.value_or(Truth{}));
    for (std::size_t k = 0; k < rows.size(); k++) {
        nlohmann::ordered_json entry;
        entry["pattern"] = halls.edges[k].pattern;
        entry["value"] = rows[k].value;
        entry["bar"] = rows[k].bar;
        if (truth) {
            entry["truth"] = rows[k].truth;
        }
        json["edges_deg"].push_back(entry);
    }
    json["late_deg"] = halls.late_deg;
    json["late_at_el_rad_s"] = halls.speed_el_rad_s;
    return json;
}

} // namespace

std::vector<Finding> findings_of(const Result &result)
{
    std::vector<Finding> findings;
    for (const Row &row : rows_of_table(result, Truth{})) {
        findings.push_back(finding_of(row));
    }
    return findings;
}

std::string table_text(const Result &result, const std::optional<Truth> &truth)
{
    std::string text = fmt::format("{:<18}{:>12}{:>12}  {:<6}{}\n", "", "measured", "bar", "",
                                   truth ? "        true       off" : "");
    for (const Row &row : rows_of_table(result, truth.value_or(Truth{}))) {
        text += row_text(row, truth.has_value());
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
    for (const Curve &curve : curves_of(result)) {
        json[curve.key] = curve_json(curve, truth);
    }
    json["flux_over_speed"] = speeds_json(result);
    json["flux_turning_wb"] = result.flux.turning_wb.value;
    if (result.flux.has_coasted) {
        json["flux_coasting_wb"] = result.flux.coasting_wb.value;
    }
    if (result.halls.measured) {
        json["halls"] = halls_json(result.halls, truth);
    }
    json["duration_s"] = duration_s;
    json["remarks"] = result.remarks;
    return json.dump(2) + '\n';
}

} // namespace nf::identify
