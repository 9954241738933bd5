// SPDX-License-Identifier: MIT
#include "compare.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

namespace nf::design
{
namespace
{

using Value = std::optional<double>;
using Figure = std::function<Value(const ModelStudy &)>;

constexpr double PAPER_KI_LIMIT_PER_S = -34.4;

class Rows
{
public:
    explicit Rows(const std::vector<ModelStudy> &studies) : studies_(studies)
    {
    }

    void add(const std::string &quantity, Value paper, const Figure &figure,
             const std::string &remark)
    {
        rows_.push_back({quantity, paper, of("printed", figure), of("computed", figure), remark});
    }

    void add_computed(const std::string &quantity, double paper, double computed,
                      const std::string &remark)
    {
        rows_.push_back({quantity, paper, std::nullopt, computed, remark});
    }

    std::vector<Comparison> take()
    {
        return std::move(rows_);
    }

private:
    Value of(const std::string &model, const Figure &figure) const
    {
        const auto found = std::find_if(studies_.begin(), studies_.end(),
                                        [&](const ModelStudy &s) { return s.model.name == model; });
        return found == studies_.end() ? std::nullopt : figure(*found);
    }

    const std::vector<ModelStudy> &studies_;
    std::vector<Comparison> rows_;
};

void nominal_rows(const DesignSettings &settings, Rows &rows)
{
    const NominalPoint &p = settings.nominal;
    const Machine machine = make_machine(settings.inputs.motor, p.inertia_kg_m2);
    const double angle_rad = p.torque_angle_deg * PI / 180;
    const Currents flowing =
        steady_currents(machine, voltages_at(p.voltage_v, angle_rad), p.speed_rad_s);
    const Voltages held = steady_voltages(machine, {p.i_q_a, p.i_d_a}, p.speed_rad_s);
    const char *const why = "the nominal point is no equilibrium of (6), (7)";
    rows.add_computed("nominal_i_q_a", p.i_q_a, flowing.q_a, why);
    rows.add_computed("nominal_i_d_a", p.i_d_a, flowing.d_a, why);
    rows.add_computed("nominal_voltage_v", p.voltage_v, std::hypot(held.q_v, held.d_v),
                      "what holds the printed currents, peak of a phase");
    rows.add_computed("nominal_torque_angle_deg", p.torque_angle_deg,
                      std::atan2(held.d_v, held.q_v) * 180 / PI,
                      "what holds the printed currents; (19) counts the angle the other way");
}

// Of the print its own value, before any correction.
double as_in_print(const ModelStudy &s, const std::string &matrix, int row, int column)
{
    for (const Correction &c : s.model.corrections) {
        if (c.matrix == matrix && c.row == row && c.column == column) {
            return c.printed;
        }
    }
    return matrix == "phi" ? s.model.discrete.phi(row - 1, column - 1)
                           : s.model.discrete.theta(row - 1, column - 1);
}

std::string correction_of(const ModelStudy &s, const std::string &matrix, int row, int column)
{
    for (const Correction &c : s.model.corrections) {
        if (c.matrix == matrix && c.row == row && c.column == column) {
            return c.reason;
        }
    }
    return "";
}

void matrix_rows(const ModelStudy &print, const std::string &name, int columns, Rows &rows)
{
    for (int row = 1; row <= MOTOR_STATES; row++) {
        for (int column = 1; column <= columns; column++) {
            const auto entry = [&](const ModelStudy &s) -> Value {
                const Discrete &d = s.model.discrete;
                return name == "phi" ? d.phi(row - 1, column - 1) : d.theta(row - 1, column - 1);
            };
            rows.add(fmt::format("{}_{}{}", name, row, column),
                     as_in_print(print, name, row, column), entry,
                     correction_of(print, name, row, column));
        }
    }
}

void model_rows(const DesignSettings &settings, Rows &rows)
{
    rows.add(
        "inertia_implied_kg_m2", settings.nominal.inertia_kg_m2,
        [](const ModelStudy &s) -> Value {
            return -s.model.discrete.phi(ANGLE, SPEED) / s.model.discrete.theta(SPEED, LOAD);
        },
        "Θ31 = -Φ43/J holds for every exact discretisation; 0.1078 is 0.011 kgf·m·s²");
    rows.add(
        "rotation_per_sample_rad", settings.nominal.speed_rad_s * settings.nominal.sample_time_s,
        [](const ModelStudy &s) -> Value {
            double angle = 0;
            for (const auto &pole : poles(s.model.discrete.phi)) {
                angle = std::max(angle, std::abs(std::arg(pole)));
            }
            return angle;
        },
        "the printed matrices are of another speed or period: their currents turn by nearly π");
}

void stability_rows(const DesignSettings &settings, Rows &rows)
{
    const Gains published = settings.published;
    const auto magnitude = [](const Gains &gains) {
        return [gains](const ModelStudy &s) -> Value {
            return std::abs(slowest_pole(s.model.discrete, gains));
        };
    };
    rows.add("slowest_pole_published", std::nullopt, magnitude(published), "stable");
    rows.add("slowest_pole_published_negative_ki", std::nullopt,
             magnitude({published.kp, -published.ki_per_s}),
             "the other sign in the print: the integrator's pole is outside");
    rows.add("slowest_pole_arbitrary", std::nullopt, magnitude(settings.arbitrary), "stable");
    rows.add(
        "ki_limit_at_published_kp_per_s", PAPER_KI_LIMIT_PER_S,
        [](const ModelStudy &s) { return s.largest_ki_per_s; },
        "no K_i < 0 is stable in (37); -34.4·T = -0.344 has the size of the printed matrices' "
        "limit; of 200 logarithmic points from 1e-4 to 1e2 the last stable ones are 0.337 and 0.168");
    rows.add(
        "ki_limit_largest_per_s", std::nullopt,
        [](const ModelStudy &s) -> Value {
            const std::vector<double> &ki = s.region.ki_per_s;
            return ki.empty() ? Value() : *std::max_element(ki.begin(), ki.end());
        },
        "over all K_p");
}

void optimum_rows(const DesignSettings &settings, Rows &rows)
{
    const CostSettings &c = settings.optimum.cost;
    const Gains published = settings.published;
    const char *const flat = "with no mode slower than optimum.slowest_time_constant_s";
    const char *const free = "without regard to stability: unstable, refused";
    rows.add(
        "optimum_kp", published.kp, [](const ModelStudy &s) -> Value { return s.optimum.gains.kp; },
        flat);
    rows.add(
        "optimum_ki_per_s", published.ki_per_s,
        [](const ModelStudy &s) -> Value { return s.optimum.gains.ki_per_s; }, flat);
    rows.add(
        "free_optimum_kp", published.kp,
        [](const ModelStudy &s) -> Value { return s.free.gains.kp; }, free);
    rows.add(
        "free_optimum_ki_per_s", -published.ki_per_s,
        [](const ModelStudy &s) -> Value { return s.free.gains.ki_per_s; }, free);
    rows.add(
        "cost_published", std::nullopt,
        [=](const ModelStudy &s) -> Value { return cost(s.model.discrete, c, published); }, "");
    rows.add(
        "cost_optimum", std::nullopt, [](const ModelStudy &s) -> Value { return s.optimum.cost; },
        "");
}

const PairResponse &response_of(const ModelStudy &s, const std::string &pair, int input)
{
    return *std::find_if(s.responses.begin(), s.responses.end(),
                         [&](const PairResponse &r) { return r.pair == pair && r.input == input; });
}

void response_rows(Rows &rows)
{
    const auto figure = [](const char *pair, int input, double ResponseFigures::*member) {
        return [=](const ModelStudy &s) -> Value {
            return response_of(s, pair, input).figures.*member;
        };
    };
    const char *const worse = "the paper says 4b settles sooner than 4a; it swings longer";
    rows.add("figure_4a_envelope_s", std::nullopt,
             figure("arbitrary", LOAD, &ResponseFigures::envelope_s), worse);
    rows.add("figure_4b_envelope_s", std::nullopt,
             figure("published", LOAD, &ResponseFigures::envelope_s), worse);
    const char *const dip = "the dip is smaller with the published pair";
    rows.add("figure_4a_dip_rad_s", std::nullopt,
             figure("arbitrary", LOAD, &ResponseFigures::peak_rad_s), dip);
    rows.add("figure_4b_dip_rad_s", std::nullopt,
             figure("published", LOAD, &ResponseFigures::peak_rad_s), dip);
    const char *const rise =
        "the published pair follows the command, the arbitrary one hardly moves";
    rows.add("figure_5a_rms_error_rad_s", std::nullopt,
             figure("arbitrary", SUPPLY, &ResponseFigures::rms_rad_s), rise);
    rows.add("figure_5b_rms_error_rad_s", std::nullopt,
             figure("published", SUPPLY, &ResponseFigures::rms_rad_s), rise);
    rows.add(
        "figure_6_settled_i_d_a", 0,
        [](const ModelStudy &s) -> Value { return response_of(s, "published", LOAD).settled[I_D]; },
        "(48) feeds neither α_r nor θ_s back to the motor, so the load's i_d stays");
}

} // namespace

std::vector<Comparison> compare_all(const DesignSettings &settings,
                                    const std::vector<ModelStudy> &studies)
{
    Rows rows(studies);
    nominal_rows(settings, rows);
    const ModelStudy &last = studies.back();
    if (last.model.name == "printed") {
        matrix_rows(last, "phi", MOTOR_STATES, rows);
        matrix_rows(last, "theta", INPUT_COUNT, rows);
    }
    model_rows(settings, rows);
    stability_rows(settings, rows);
    optimum_rows(settings, rows);
    response_rows(rows);
    return rows.take();
}

} // namespace nf::design
