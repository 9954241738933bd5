// SPDX-License-Identifier: MIT
#include "report.h"

#include "discretise.h"
#include "drive_gains.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf::design
{
namespace
{

using Json = nlohmann::ordered_json;

constexpr const char *STATE_KEYS[] = {"i_q_a",
                                      "i_d_a",
                                      "speed_rad_s",
                                      "angle_rad",
                                      "speed_error_sum_rad_s",
                                      "current_angle_rad",
                                      "firing_angle_rad"};
constexpr const char *INPUT_KEYS[] = {"load_nm", "supply_speed_rad_s"};
constexpr const char *STEP_NAMES[] = {"load", "speed"};

template <typename Matrix> Json json_of(const Matrix &matrix)
{
    Json rows = Json::array();
    for (Eigen::Index r = 0; r < matrix.rows(); r++) {
        Json row = Json::array();
        for (Eigen::Index c = 0; c < matrix.cols(); c++) {
            row.push_back(matrix(r, c));
        }
        rows.push_back(row);
    }
    return rows;
}

Json json_of(const Gains &gains)
{
    return {{"kp", gains.kp}, {"ki_per_s", gains.ki_per_s}};
}

Json json_of(const Optimum &optimum, const Discrete &motor)
{
    Json json = json_of(optimum.gains);
    json["cost"] = optimum.cost;
    json["slowest_pole_magnitude"] = std::abs(slowest_pole(motor, optimum.gains));
    json["stable"] = is_stable(motor, optimum.gains);
    json["iterations"] = optimum.iterations;
    json["converged"] = optimum.converged;
    return json;
}

Json json_of(const Pair &pair, const Discrete &motor)
{
    Json json = {{"name", pair.name}, {"kp", pair.gains.kp}, {"ki_per_s", pair.gains.ki_per_s}};
    Json list = Json::array();
    for (const std::complex<double> &pole : poles(close_loop(motor, pair.gains).a)) {
        list.push_back(
            {{"real", pole.real()}, {"imaginary", pole.imag()}, {"magnitude", std::abs(pole)}});
    }
    json["poles"] = list;
    return json;
}

Json json_of(const PairResponse &r)
{
    Json json = {{"pair", r.pair},
                 {"step", STEP_NAMES[r.input]},
                 {"peak_rad_s", r.figures.peak_rad_s},
                 {"peak_time_s", r.figures.peak_time_s},
                 {"overshoot_rad_s", r.figures.overshoot_rad_s},
                 {"rms_error_rad_s", r.figures.rms_rad_s},
                 {"envelope_s", r.figures.envelope_s},
                 {"slowest_s", r.figures.slowest_s},
                 {"settled_i_q_a", r.settled[I_Q]},
                 {"settled_i_d_a", r.settled[I_D]},
                 {"time_s", r.response.time_s}};
    for (int k = 0; k < PHASE_STATE_COUNT; k++) {
        Json values = Json::array();
        for (const PhaseVector &state : r.response.states) {
            values.push_back(state[k]);
        }
        json[STATE_KEYS[k]] = values;
    }
    json[INPUT_KEYS[SUPPLY]] = r.response.output_rad_s;
    return json;
}

Json json_of(const Correction &c)
{
    return {{"matrix", c.matrix},   {"row", c.row},   {"column", c.column},
            {"printed", c.printed}, {"used", c.used}, {"reason", c.reason}};
}

Json json_of(const ModelStudy &s)
{
    const Discrete &motor = s.model.discrete;
    Json json = {{"matrices", s.model.name},
                 {"sample_time_s", motor.sample_time_s},
                 {"phi", json_of(motor.phi)},
                 {"theta", json_of(motor.theta)},
                 {"corrections", Json::array()},
                 {"stable_region", {{"kp", s.region.kp}, {"largest_ki_per_s", s.region.ki_per_s}}},
                 {"largest_ki_at_published_kp_per_s", nullptr},
                 {"optimum", json_of(s.optimum, motor)},
                 {"free_optimum", json_of(s.free, motor)},
                 {"pairs", Json::array()},
                 {"responses", Json::array()}};
    if (s.largest_ki_per_s) {
        json["largest_ki_at_published_kp_per_s"] = *s.largest_ki_per_s;
    }
    for (const Correction &correction : s.model.corrections) {
        json["corrections"].push_back(json_of(correction));
    }
    for (const Pair &pair : s.pairs) {
        json["pairs"].push_back(json_of(pair, motor));
    }
    for (const PairResponse &response : s.responses) {
        json["responses"].push_back(json_of(response));
    }
    return json;
}

Json json_of(const std::vector<Comparison> &rows)
{
    const auto value = [](const std::optional<double> &figure) {
        return figure ? Json(*figure) : Json(nullptr);
    };
    Json json = Json::array();
    for (const Comparison &row : rows) {
        json.push_back({{"quantity", row.quantity},
                        {"paper", value(row.paper)},
                        {"printed", value(row.printed)},
                        {"computed", value(row.computed)},
                        {"remark", row.remark}});
    }
    return json;
}

Json json_of(const NominalPoint &p)
{
    return {{"speed_rad_s", p.speed_rad_s},
            {"voltage_v", p.voltage_v},
            {"torque_angle_deg", p.torque_angle_deg},
            {"i_q_a", p.i_q_a},
            {"i_d_a", p.i_d_a},
            {"inertia_kg_m2", p.inertia_kg_m2},
            {"voltage_per_speed_v_s_per_rad", p.voltage_per_speed_v_s_per_rad},
            {"sample_time_s", p.sample_time_s},
            {"k2", p.k2}};
}

Json json_of(const CostSettings &c)
{
    return {{"q1", c.q1},
            {"q2", c.q2},
            {"q3", c.q3},
            {"horizon_samples", c.horizon_samples},
            {"state", state_words()[static_cast<std::size_t>(c.state)]},
            {"input", input_words()[static_cast<std::size_t>(c.input)]}};
}

const ModelStudy &find(const std::vector<ModelStudy> &studies, const std::string &name)
{
    return *std::find_if(studies.begin(), studies.end(),
                         [&](const ModelStudy &s) { return s.model.name == name; });
}

VoltageLoopGains drive_gains(const DesignSettings &settings, const ModelStudy &s)
{
    return voltage_loop_gains(s.optimum.gains, settings.nominal.voltage_per_speed_v_s_per_rad);
}

// A pole's distance from the unit circle, however small, is what decides.
std::string from_one(double magnitude)
{
    return fmt::format("1 {} {:.3g}", magnitude < 1 ? '-' : '+', std::abs(1 - magnitude));
}

std::string pair_line(const ModelStudy &s, const Pair &pair, const CostSettings &settings)
{
    const Discrete &motor = s.model.discrete;
    const double magnitude = std::abs(slowest_pole(motor, pair.gains));
    return fmt::format("  {:<12}{:>9.4f}{:>11.5f}{:>14}{:>11.3g} {:>10.5f}\n", pair.name,
                       pair.gains.kp, pair.gains.ki_per_s, from_one(magnitude),
                       time_constant_s(magnitude, motor.sample_time_s),
                       cost(motor, settings, pair.gains));
}

std::string study_text(const DesignSettings &settings, const ModelStudy &s)
{
    std::string text = fmt::format("{} matrices\n", s.model.name);
    text += fmt::format("  {:<12}{:>9}{:>11}{:>14}{:>11}{:>11}\n", "pair", "K_p", "K_i, 1/s",
                        "slowest", "of, s", "cost");
    for (const Pair &pair : s.pairs) {
        text += pair_line(s, pair, settings.optimum.cost);
    }
    const double magnitude = std::abs(slowest_pole(s.model.discrete, s.free.gains));
    text += fmt::format("  least cost at all: K_p = {:.4f}, K_i = {:.4f} 1/s, cost {:.5f}, {} by "
                        "its pole at {}\n",
                        s.free.gains.kp, s.free.gains.ki_per_s, s.free.cost,
                        magnitude < 1 ? "stable" : "refused as unstable", from_one(magnitude));
    if (s.largest_ki_per_s) {
        text += fmt::format("  stable at K_p = {:g}: 0 < K_i < {:.4f} 1/s\n", settings.published.kp,
                            *s.largest_ki_per_s);
    }
    return text;
}

std::string number(const std::optional<double> &value)
{
    return value ? fmt::format("{:.6g}", *value) : "-";
}

} // namespace

std::string design_json(const DesignSettings &settings, const std::vector<ModelStudy> &studies,
                        const std::string &chosen)
{
    const Continuous continuous = linearise(
        make_machine(settings.inputs.motor, settings.nominal.inertia_kg_m2), settings.nominal);
    const ModelStudy &used = find(studies, chosen);
    const VoltageLoopGains gains = drive_gains(settings, used);
    Json json = {{"design", settings.file},
                 {"motor", settings.inputs.motor.name},
                 {"states", STATE_KEYS},
                 {"inputs", INPUT_KEYS},
                 {"nominal", json_of(settings.nominal)},
                 {"f", json_of(continuous.f)},
                 {"g", json_of(continuous.g)},
                 {"cost_settings", json_of(settings.optimum.cost)},
                 {"slowest_time_constant_s", settings.optimum.slowest_time_constant_s},
                 {"start", json_of(settings.optimum.start)},
                 {"chosen_matrices", chosen},
                 {"voltage_loop",
                  {{"kp_v_s_per_rad", gains.kp_v_s_per_rad},
                   {"ki_v_per_rad", gains.ki_v_per_rad},
                   {"sample_time_s", used.model.discrete.sample_time_s}}},
                 {"models", Json::array()}};
    for (const ModelStudy &s : studies) {
        json["models"].push_back(json_of(s));
    }
    json["comparison"] = json_of(compare_all(settings, studies));
    return json.dump(1) + '\n';
}

std::string design_text(const DesignSettings &settings, const std::vector<ModelStudy> &studies,
                        const std::string &chosen)
{
    const CostSettings &c = settings.optimum.cost;
    std::string text = fmt::format(
        "{}: {}, T = {:g} s\ncost: unit step of {}, X = {}, Q = {:g}, {:g}, {:g}, {} samples; no "
        "mode slower than {:g} s\n\n",
        settings.file, settings.inputs.motor.name, settings.nominal.sample_time_s,
        input_words()[static_cast<std::size_t>(c.input)],
        state_words()[static_cast<std::size_t>(c.state)], c.q1, c.q2, c.q3, c.horizon_samples,
        settings.optimum.slowest_time_constant_s);
    for (const ModelStudy &s : studies) {
        text += study_text(settings, s) + '\n';
    }
    const ModelStudy &used = find(studies, chosen);
    return text +
           voltage_loop_toml(drive_gains(settings, used), used.model.discrete.sample_time_s,
                             fmt::format("gaindesign, {}, {} matrices", settings.file, chosen));
}

std::string comparison_text(const std::vector<Comparison> &rows)
{
    std::string text = fmt::format("{:<36}{:>13}{:>13}{:>13}  {}\n", "quantity", "paper", "printed",
                                   "computed", "remark");
    for (const Comparison &row : rows) {
        const std::string line =
            fmt::format("{:<36}{:>13}{:>13}{:>13}  {}", row.quantity, number(row.paper),
                        number(row.printed), number(row.computed), row.remark);
        text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
    }
    return text;
}

std::string poles_text(const Model &model, const Gains &gains)
{
    std::string text = fmt::format("{} matrices: {}\n", model.name,
                                   is_stable(model.discrete, gains) ? "stable" : "UNSTABLE");
    for (const std::complex<double> &pole : poles(close_loop(model.discrete, gains).a)) {
        const double magnitude = std::abs(pole);
        const std::string decay =
            magnitude < 1 ? fmt::format("decays with {:.4g} s",
                                        time_constant_s(magnitude, model.discrete.sample_time_s))
                          : "does not decay";
        text += fmt::format("  {:>10.6f} {:>+10.6f}i  magnitude {}, {}\n", pole.real(), pole.imag(),
                            from_one(magnitude), decay);
    }
    return text;
}

} // namespace nf::design
