// SPDX-License-Identifier: MIT
#include "inductance_fit.h"

#include "least_squares.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace nf::identify
{
namespace
{

constexpr size_t BURSTS_LEAST = 4; // of an axis
constexpr int ROUNDS = 20;
constexpr double MODULATOR = 1.0 / 4096; // of a voltage: the reciprocal of the bus

// i_d rises with the pulses across, as they take its loss from the legs: so its term looks like that of λ². What it does
// to 1/L_q at the continuous current, over 1/L_q, is therefore taken to be about this, ± this.
constexpr double CROSS = 0.03;
constexpr double CROSS_ERROR = 0.03;
constexpr double REPEATS = 0.002; // of 1/L: how well two bursts agree

// Of the fall of L_d by the continuous current: how far a straight line may be wrong at its end.
constexpr double CURVE_D = 0.15;
constexpr double CURVE_Q = 0.05;

// A burst and the inductance that explains it.
struct Shown {
    Burst burst;
    double inductance_h;
};

double first_guess(const std::vector<Burst> &bursts, bool along)
{
    double sum = 0;
    size_t count = 0;
    for (const Burst &burst : bursts) {
        if (burst.along == along && burst.peak_a() > 0) {
            sum += burst.pulse_v * burst.quarter * burst.period_s / burst.peak_a();
            count++;
        }
    }
    if (count < BURSTS_LEAST) {
        throw std::runtime_error(std::string("too few bursts ") + (along ? "along" : "across") +
                                 " the current to find its inductance");
    }
    return sum / static_cast<double>(count);
}

std::vector<Shown> shown_of(const std::vector<Burst> &bursts, bool along, const LegModel &legs,
                            const Moved &motor)
{
    std::vector<Shown> shown;
    for (const Burst &burst : bursts) {
        if (burst.along == along) {
            shown.push_back({burst, inductance_of(burst, legs, motor)});
        }
    }
    return shown;
}

using Row = std::function<Eigen::RowVectorXd(const Shown &)>;

// 1/L over `scale`, and for three terms what is known of the third one before.
Fit inverse_fit(const std::vector<Shown> &shown, double scale, const Row &row)
{
    const auto rows = static_cast<Eigen::Index>(shown.size());
    const Eigen::Index terms = row(shown.front()).size();
    const Eigen::Index known = terms > 2 ? 1 : 0;
    Eigen::VectorXd y(rows + known);
    Eigen::MatrixXd a(rows + known, terms);
    for (Eigen::Index k = 0; k < rows; k++) {
        const Shown &one = shown[static_cast<size_t>(k)];
        y[k] = 1 / one.inductance_h / scale;
        a.row(k) = row(one);
    }
    if (known > 0) {
        a.row(rows) = Eigen::RowVector3d(0, 0, REPEATS / CROSS_ERROR);
        y[rows] = REPEATS / CROSS_ERROR * CROSS;
    }
    return linear_least_squares(a, y);
}

// λ of the current at which L_q is stated, over that of the same current without saturation.
double share_of_flux(double a, double b)
{
    double share = 1 / a;
    for (int round = 0; round < ROUNDS; round++) {
        share = 1 / (a + b * share * share);
    }
    return share;
}

void fit_d(Inductances &found, const std::vector<Shown> &shown, double guess_h)
{
    const double reference_a = found.continuous_a;
    const Fit fit = inverse_fit(shown, 1 / guess_h, [&](const Shown &one) {
        return Eigen::RowVector2d(1, one.burst.mean_a / reference_a);
    });
    found.per_d = fit.parameters[0] / guess_h;
    found.bend_d = fit.parameters[1] / guess_h / reference_a;
    found.d_h.value = 1 / found.per_d;
    found.d_h.std = found.d_h.value * fit.std(0) / fit.parameters[0];
}

void fit_q(Inductances &found, const std::vector<Shown> &shown, double guess_h)
{
    const double reference_a = found.continuous_a;
    const Fit fit = inverse_fit(shown, 1 / guess_h, [&](const Shown &one) {
        const double flux = one.burst.peak_a() * one.inductance_h / (reference_a * guess_h);
        return Eigen::RowVector3d(1, flux * flux, one.burst.mean_a / reference_a);
    });
    const double share = share_of_flux(fit.parameters[0], fit.parameters[1]);
    const Eigen::RowVector3d at(1, share * share, 0);
    found.q_h.value = share * guess_h;
    found.fall_q = std::abs(1 - fit.parameters[0] * share);
    found.q_h.std = found.q_h.value * share * std::sqrt((at * fit.covariance * at.transpose())(0));
}

Inductances values_of(const std::vector<Burst> &bursts, const LegModel &legs, const Moved &rotor)
{
    Inductances found;
    Moved motor = rotor;
    motor.inductance_d_h = first_guess(bursts, true);
    motor.inductance_q_h = first_guess(bursts, false);
    for (const Burst &burst : bursts) {
        found.continuous_a = std::max(found.continuous_a, burst.held_a);
        found.quarter_q = burst.along ? found.quarter_q : std::max(found.quarter_q, burst.quarter);
    }
    fit_d(found, shown_of(bursts, true, legs, motor), motor.inductance_d_h);
    motor.inductance_d_h = found.d_h.value;
    fit_q(found, shown_of(bursts, false, legs, motor), motor.inductance_q_h);
    return found;
}

} // namespace

double Inductances::flux_d(double current_a) const
{
    return current_a / (per_d + bend_d * current_a / 2);
}

Inductances fit_inductances(const std::vector<Burst> &bursts, const Legs &legs, const Moved &rotor)
{
    Inductances found = values_of(bursts, legs.model, rotor);
    LegModel other = legs.model;
    other.loss_v += legs.loss_v.bar();
    other.resistance_ohm -= legs.resistance_ohm.bar();
    const Inductances then = values_of(bursts, other, rotor);
    const double fall_d = std::abs(found.bend_d) * found.continuous_a / found.per_d;
    found.d_h.bound = std::abs(then.d_h.value - found.d_h.value) +
                      (MODULATOR + CURVE_D * fall_d) * found.d_h.value;
    found.q_h.bound = std::abs(then.q_h.value - found.q_h.value) +
                      (MODULATOR + CURVE_Q * found.fall_q) * found.q_h.value;
    return found;
}

} // namespace nf::identify
