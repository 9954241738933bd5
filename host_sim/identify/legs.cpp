// SPDX-License-Identifier: MIT
#include "legs.h"

#include "least_squares.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nf::identify
{
namespace
{

constexpr size_t LEVELS_LEAST = 6;
constexpr double STARTS[] = {0.003, 0.02, 0.1, 0.4}; // of i_k over the largest current
constexpr double DRIFT_SHOWS = 4;                    // of its standard deviation
constexpr int TURN_PARTS = 48;
constexpr double VOLTAGE_STEP = 1.0 / 32768; // of the bus: demanded voltages are Q15

// Parameters of the fit.
enum Parameter {
    RESISTANCE,
    LOSS,
    LOG_KNEE,
    MISMATCH,
    DRIFT // of R over the levels
};

using Shape = double (*)(double z);

// The other usual shape of a knee, likewise half of it at 1.
double arctan_share(double z)
{
    return 2 / PI * std::atan(z);
}

struct Levels {
    std::vector<Window> windows;
    double largest_a = 0;
    double bus_v = 0;

    // −0.5…0.5
    double moment(size_t k) const
    {
        return static_cast<double>(k) / static_cast<double>(windows.size() - 1) - 0.5;
    }
};

Levels levels_of(const Records &records)
{
    Levels levels{records.of("still")};
    if (levels.windows.size() < LEVELS_LEAST) {
        throw std::runtime_error("too few levels of current at rest to find the resistance");
    }
    double least_a = HUGE_VAL;
    for (const Window &window : levels.windows) {
        levels.largest_a = std::max(levels.largest_a, window.current_a.real());
        least_a = std::min(least_a, window.current_a.real());
        levels.bus_v += window.bus_v / static_cast<double>(levels.windows.size());
    }
    if (least_a > levels.largest_a / 2 || levels.bus_v <= 0) {
        throw std::runtime_error("the levels of current at rest do not differ");
    }
    return levels;
}

double gain(double mismatch, int axis)
{
    return axis == 0 ? 1 + mismatch : (axis == 1 ? 1 - mismatch : 1);
}

Eigen::VectorXd residuals(const Levels &levels, const Eigen::VectorXd &x, Shape share)
{
    Eigen::VectorXd left(static_cast<Eigen::Index>(levels.windows.size()));
    const double knee_a = std::exp(std::clamp(x[LOG_KNEE], -50.0, 50.0));
    for (size_t k = 0; k < levels.windows.size(); k++) {
        const Window &window = levels.windows[k];
        const double i = window.current_a.real() / gain(x[MISMATCH], window.axis);
        const double drift = x.size() > DRIFT ? x[DRIFT] * levels.moment(k) : 0;
        const double lost = share(i / knee_a) + share(i / 2 / knee_a);
        left[static_cast<Eigen::Index>(k)] = (x[RESISTANCE] + drift) * i +
                                             2.0 / 3 * x[LOSS] * lost - window.voltage_v.real();
    }
    return left;
}

// R and V0 of a loss without a knee.
Eigen::VectorXd straight_line(const Levels &levels)
{
    const auto rows = static_cast<Eigen::Index>(levels.windows.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Ones(rows, 2);
    Eigen::VectorXd y(rows);
    for (Eigen::Index k = 0; k < rows; k++) {
        a(k, 0) = levels.windows[static_cast<size_t>(k)].current_a.real();
        y[k] = levels.windows[static_cast<size_t>(k)].voltage_v.real();
    }
    return linear_least_squares(a, y).parameters;
}

Fit fit_of(const Levels &levels, Shape share)
{
    const Eigen::VectorXd line = straight_line(levels);
    const auto from = [&](const Eigen::VectorXd &x) { return residuals(levels, x, share); };
    Fit best;
    best.rms = HUGE_VAL;
    for (const double start : STARTS) {
        Eigen::VectorXd x(DRIFT);
        x << line[0], std::max(0.75 * line[1], 1e-6 * levels.bus_v),
            std::log(start * levels.largest_a), 0;
        const Fit fit = least_squares(from, x);
        if (fit.rms < best.rms) {
            best = fit;
        }
    }
    return best;
}

// The winding heats up: R drifts, where that is more than noise.
Fit with_drift(const Levels &levels, const Fit &without)
{
    Eigen::VectorXd x(DRIFT + 1);
    x << without.parameters, 0;
    const Fit fit = least_squares(
        [&](const Eigen::VectorXd &at) { return residuals(levels, at, knee_share); }, x);
    return std::abs(fit.parameters[DRIFT]) > DRIFT_SHOWS * fit.std(DRIFT) ? fit : without;
}

} // namespace

double knee_share(double z)
{
    const double size = std::abs(z);
    return size <= 1 ? z / 2 : std::copysign(1 - 1 / (2 * size), z);
}

double leg_loss(const LegModel &legs, double current_a)
{
    return legs.loss_v * knee_share(current_a / legs.knee_a);
}

std::complex<double> loss_at_rest(const LegModel &legs, std::complex<double> current_a)
{
    const double across = std::sqrt(3.0) / 2 * current_a.imag();
    const double a = leg_loss(legs, current_a.real());
    const double b = leg_loss(legs, -current_a.real() / 2 + across);
    const double c = leg_loss(legs, -current_a.real() / 2 - across);
    return {2.0 / 3 * (a - (b + c) / 2), (b - c) / std::sqrt(3.0)};
}

double loss_turning(const LegModel &legs, double current_a)
{
    double sum = 0;
    for (int k = 0; k < TURN_PARTS; k++) {
        const std::complex<double> direction = std::polar(1.0, TWO_PI * (k + 0.5) / TURN_PARTS);
        sum += (loss_at_rest(legs, current_a * direction) * std::conj(direction)).real();
    }
    return sum / TURN_PARTS;
}

double gain_along(const Legs &legs, int axis)
{
    return gain(legs.mismatch.value, axis);
}

double gain_across(const Legs &legs, int axis)
{
    return gain(-legs.mismatch.value, axis);
}

Legs fit_legs(const Records &records)
{
    const Levels levels = levels_of(records);
    const Fit fit = with_drift(levels, fit_of(levels, knee_share));
    const Fit other = fit_of(levels, arctan_share);
    // Another shape of the knee counts as far as the levels do not rule it out.
    const double doubt = std::min(1.0, fit.rms / other.rms);
    const double floor_v = levels.bus_v * VOLTAGE_STEP;
    const auto estimate = [&](Parameter which, double unseen) {
        return Estimate{fit.parameters[which], fit.std(which),
                        doubt * std::abs(fit.parameters[which] - other.parameters[which]) + unseen};
    };
    Legs legs;
    legs.resistance_ohm = estimate(RESISTANCE, floor_v / levels.largest_a);
    legs.loss_v = estimate(LOSS, floor_v);
    legs.mismatch = estimate(MISMATCH, 0);
    const double knee_a = std::exp(std::clamp(fit.parameters[LOG_KNEE], -50.0, 50.0));
    legs.knee_a = {knee_a, knee_a * fit.std(LOG_KNEE), 0};
    legs.model = {legs.resistance_ohm.value, legs.loss_v.value, knee_a};
    legs.heating = fit.parameters.size() > DRIFT
                       ? fit.parameters[DRIFT] / fit.parameters[RESISTANCE]
                       : 0;
    legs.bus_v = levels.bus_v;
    legs.largest_a = levels.largest_a;
    return legs;
}

} // namespace nf::identify
