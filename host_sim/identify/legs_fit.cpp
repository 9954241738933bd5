// SPDX-License-Identifier: MIT
#include "legs_fit.h"

#include "config.h"
#include "least_squares.h"

#include <algorithm>
#include <cmath>

namespace nf::identify
{
namespace
{

constexpr double TWO_THIRDS = 2.0 / 3;
constexpr std::size_t LEVELS_MIN = 12;
constexpr double HALF_SQRT3 = 0.86602540378443864676;
// What is known of the way from the demand to the motor: the modulator's reciprocal of the bus is good to 2^-11, the
// bus converter to half a count of 4096. It scales all voltages.
constexpr double VOLTAGE_SCALE = 5e-4;
// Found on simulated motors: of R, the sensors and what the curve's shape makes of it; of the bus voltage, the timer's steps.
constexpr double RESISTANCE_UNSURE = 2e-3;
constexpr double TIMER_UNSURE = 1.6e-5;

// Another shape with the same slope at zero and the same end: how far R moves with it says how much the knee's shape counts.
double other_share(double z)
{
    constexpr double half_pi = 1.57079632679489661923;
    return std::atan(z * half_pi / 2) / half_pi;
}

// Of sensor a, b and of their sum, for a mismatch m.
double true_current(const Record &level, double mismatch)
{
    const double gain[] = {1 + mismatch / 2, 1 - mismatch / 2, 1};
    return level.i_a.real() / gain[level.axis];
}

enum Parameter {
    RESISTANCE,
    LOSS,
    LOG_KNEE,
    MISMATCH,
    PARAMETERS
};

Eigen::VectorXd residuals_of(const std::vector<Record> &levels, const Eigen::VectorXd &p,
                             double (*shape)(double))
{
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(levels.size()));
    const double knee = std::exp(p[LOG_KNEE]);
    for (std::size_t k = 0; k < levels.size(); k++) {
        const double i = true_current(levels[k], p[MISMATCH]);
        const double lost = TWO_THIRDS * p[LOSS] * (shape(i / knee) + shape(i / 2 / knee));
        residuals[static_cast<Eigen::Index>(k)] =
            p[RESISTANCE] * i + lost - levels[k].voltage_v.real();
    }
    return residuals;
}

double largest_current(const std::vector<Record> &levels)
{
    double largest = 0;
    for (const Record &level : levels) {
        largest = std::max(largest, level.i_a.real());
    }
    return largest;
}

// The knee decides into which valley the fit falls: the best of several beginnings.
Fit fit_shape(const std::vector<Record> &levels, double (*shape)(double))
{
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(levels.size()), 2);
    Eigen::VectorXd voltage(rows.rows());
    const double largest = largest_current(levels);
    for (Eigen::Index k = 0; k < rows.rows(); k++) {
        const Record &level = levels[static_cast<std::size_t>(k)];
        rows.row(k) << level.i_a.real(), 1;
        voltage[k] = level.voltage_v.real();
    }
    const Fit line = fit_linear(rows, voltage);
    Fit best;
    for (const double at : {0.003, 0.02, 0.1, 0.4}) {
        Eigen::VectorXd start(static_cast<Eigen::Index>(PARAMETERS));
        start << line.value[0], std::max(0.75 * line.value[1], 1e-4), std::log(at * largest), 0;
        const Fit fit = fit_curve(
            [&](const Eigen::VectorXd &p) { return residuals_of(levels, p, shape); }, start);
        if (best.value.size() == 0 || fit.rms < best.rms) {
            best = fit;
        }
    }
    return best;
}

void add_scale_bounds(Legs &legs, double largest_a)
{
    const double drop_v = legs.resistance_ohm.value * largest_a;
    legs.resistance_ohm.bound +=
        (VOLTAGE_SCALE * drop_v + RESISTANCE_UNSURE * (drop_v + legs.loss_v.value)) / largest_a;
    legs.loss_v.bound += VOLTAGE_SCALE * drop_v + TIMER_UNSURE * legs.bus_v;
}

} // namespace

double lost_share(double z)
{
    const double size = std::abs(z);
    const double lost = size <= 1 ? size / 2 : 1 - 1 / (2 * size);
    return z < 0 ? -lost : lost;
}

double Legs::lost_v(double leg_a) const
{
    return loss_v.value * lost_share(leg_a / knee_a.value);
}

std::complex<double> Legs::lost_v(std::complex<double> current) const
{
    const double a = lost_v(current.real());
    const double b = lost_v(-current.real() / 2 + HALF_SQRT3 * current.imag());
    const double c = lost_v(-current.real() / 2 - HALF_SQRT3 * current.imag());
    return {TWO_THIRDS * (a - (b + c) / 2), TWO_THIRDS * HALF_SQRT3 * (b - c)};
}

double Legs::lost_turning_v(double current_a) const
{
    constexpr int angles = 48;
    constexpr double turn = 6.28318530717958647693;
    double sum = 0;
    for (int k = 0; k < angles; k++) {
        const std::complex<double> current = std::polar(current_a, (k + 0.5) / angles * turn);
        const std::complex<double> lost = lost_v(current);
        sum += (lost * std::conj(current)).real() / current_a;
    }
    return sum / angles;
}

Legs fit_legs(const Records &records)
{
    const std::vector<Record> levels = records.of("still");
    if (levels.size() < LEVELS_MIN) {
        throw ConfigError(
            "the records have too few levels of current at rest: the identification did not come that far");
    }
    const Fit fit = fit_shape(levels, lost_share);
    const Fit other = fit_shape(levels, other_share);
    Legs legs;
    const auto value = [&](Parameter which) {
        return Value{fit.value[which], fit.std[which],
                     std::abs(fit.value[which] - other.value[which]) / 2};
    };
    legs.resistance_ohm = value(RESISTANCE);
    legs.loss_v = value(LOSS);
    legs.mismatch = {fit.value[MISMATCH], fit.std[MISMATCH], 0};
    legs.knee_a.value = std::exp(fit.value[LOG_KNEE]);
    legs.knee_a.std = legs.knee_a.value * fit.std[LOG_KNEE];
    for (const Record &level : levels) {
        legs.bus_v += level.bus_v / static_cast<double>(levels.size());
    }
    legs.period_s = records.scales.period_s;
    add_scale_bounds(legs, largest_current(levels));
    return legs;
}

} // namespace nf::identify
