// SPDX-License-Identifier: MIT
#include "legs_fit.h"

#include "config.h"
#include "least_squares.h"
#include "leg_axes.h"

#include <algorithm>
#include <cmath>

namespace nf::identify
{
namespace
{

constexpr std::size_t LEVELS_MIN = 12;
// What is known of the way from the demand to the motor, which scales all voltages: the modulator's
// reciprocal of the bus is good to 2^-11, the bus converter to half a count of 4096.
constexpr double VOLTAGE_SCALE = 5e-4;
// Of the bus voltage: a step of the timer and its rounding, averaged over a window and over the
// axes.
constexpr double TIMER_UNSURE = 1.6e-5;
// Of the decay in a period times the loss, and of its square: the sample is not the mean of a
// current that decays between two edges. Their sizes were found on simulated motors.
constexpr double RIPPLE_OF_R = 0.04;
constexpr double SAMPLE_OF_R = 0.012;
constexpr double RIPPLE_OF_LOSS = 0.015;
constexpr double RIPPLE_OF_KNEE = 2e-3;
// Of the largest current: the lowest level is far above most knees. Of the knee likewise.
constexpr double KNEE_UNSEEN = 2.5e-4;
constexpr double KNEE_UNSURE = 5e-3;
constexpr double MISMATCH_UNSURE = 6e-4; // of a gain: the steps of the converter
// Of the loss: the drop of the devices, which a bus that sags under the current does not change as
// it changes the dead time's.
constexpr double DROP_OF_LOSS = 0.25;
// Of R: a smaller rise is not told from what differs between the axes, and then half of it is in
// the bound of R.
constexpr double WARMING_SEEN = 0.01;
constexpr double WARMING_SIGMAS = 3;

// The loss of a leg whose capacitance is all at the ends of the output's swing, as that of silicon
// nearly is. Beyond the knee it is that of a constant capacitance, as both swings of a period are
// symmetric; below, it is as different as it can be. Half of what R moves with it is a bound on
// what the knee's shape does.
double other_share(double z)
{
    const double size = std::abs(z);
    const double lost = size <= 0.5 ? 0 : 1 - 1 / (2 * size);
    return z < 0 ? -lost : lost;
}

// A level of current at rest.
struct Level {
    int axis = 0;
    double measured_a = 0;
    double voltage_v = 0;
    double bus_share = 1; // of the mean over all levels
    // What the winding has taken up until the middle of it: 0 at the beginning, 1 at the end of the
    // rest.
    double heat = 0;
};

bool is_at_rest(const Record &record)
{
    return record.kind == "still" || record.kind == "burst" || record.kind == "catch";
}

double mean_bus(const Records &records)
{
    const std::vector<Record> levels = records.of("still");
    double sum = 0;
    for (const Record &level : levels) {
        sum += level.bus_v;
    }
    return sum / static_cast<double>(levels.size());
}

// A winding takes up i²·t, and in these few seconds it gives off next to nothing.
std::vector<Level> levels_of(const Records &records)
{
    const double mean_v = mean_bus(records);
    std::vector<Level> levels;
    double taken_up = 0;
    for (const Record &r : records.all) {
        const double more = is_at_rest(r) ? std::norm(r.i_a) * r.ticks : 0;
        if (r.kind == "still") {
            levels.push_back(
                {r.axis, r.i_a.real(), r.voltage_v.real(), r.bus_v / mean_v, taken_up + more / 2});
        }
        taken_up += more;
    }
    for (Level &level : levels) {
        level.heat /= taken_up;
    }
    return levels;
}

// Of sensor a, b and of their sum, for a mismatch m.
double true_current(const Level &level, double mismatch)
{
    const double gain[] = {1 + mismatch / 2, 1 - mismatch / 2, 1};
    return level.measured_a / gain[level.axis];
}

enum Parameter {
    RESISTANCE,
    LOSS,
    LOG_KNEE,
    MISMATCH,
    THIRD,   // R on the axis of phase c over that of all, less one
    WARMING, // the share by which R rises from the beginning of the rest to its end
    PARAMETERS
};

Eigen::VectorXd residuals_of(const std::vector<Level> &levels, const Eigen::VectorXd &p,
                             double (*shape)(double))
{
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(levels.size()));
    const double knee = std::exp(p[LOG_KNEE]);
    for (std::size_t k = 0; k < levels.size(); k++) {
        const double i = true_current(levels[k], p[MISMATCH]);
        const double loss = p[LOSS] * levels[k].bus_share;
        const double lost = TWO_THIRDS * loss * (shape(i / knee) + shape(i / 2 / knee));
        const double warming = p.size() > WARMING ? p[WARMING] : 0;
        const double unlike = p[THIRD] * (levels[k].axis == 2 ? 1 : -0.5);
        const double resistance = p[RESISTANCE] * (1 + unlike) * (1 + warming * levels[k].heat);
        residuals[static_cast<Eigen::Index>(k)] = resistance * i + lost - levels[k].voltage_v;
    }
    return residuals;
}

double largest_current(const std::vector<Level> &levels)
{
    double largest = 0;
    for (const Level &level : levels) {
        largest = std::max(largest, level.measured_a);
    }
    return largest;
}

// The knee decides into which valley the fit falls: the best of several beginnings. parameters: the
// last one may be left out, and is 0 then.
Fit fit_shape(const std::vector<Level> &levels, double (*shape)(double), Parameter parameters)
{
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(levels.size()), 2);
    Eigen::VectorXd voltage(rows.rows());
    const double largest = largest_current(levels);
    for (Eigen::Index k = 0; k < rows.rows(); k++) {
        const Level &level = levels[static_cast<std::size_t>(k)];
        rows.row(k) << level.measured_a, 1;
        voltage[k] = level.voltage_v;
    }
    const Fit line = fit_linear(rows, voltage);
    Fit best;
    for (const double at : {0.003, 0.02, 0.1, 0.4}) {
        Eigen::VectorXd start = Eigen::VectorXd::Zero(parameters);
        start[RESISTANCE] = line.value[0];
        start[LOSS] = std::max(0.75 * line.value[1], 1e-4);
        start[LOG_KNEE] = std::log(at * largest);
        const Fit fit = fit_curve(
            [&](const Eigen::VectorXd &p) { return residuals_of(levels, p, shape); }, start);
        if (best.value.size() == 0 || fit.rms < best.rms) {
            best = fit;
        }
    }
    return best;
}

void add_scale_bounds(Legs &legs)
{
    legs.resistance_ohm.bound +=
        VOLTAGE_SCALE * legs.resistance_ohm.value + TIMER_UNSURE * legs.bus_v / legs.largest_a;
    legs.loss_v.bound += VOLTAGE_SCALE * legs.loss_v.value + TIMER_UNSURE * legs.bus_v;
    legs.knee_a.bound += KNEE_UNSEEN * legs.largest_a + KNEE_UNSURE * legs.knee_a.value;
    legs.mismatch.bound +=
        MISMATCH_UNSURE + TIMER_UNSURE * legs.bus_v / (legs.resistance_ohm.value * legs.largest_a);
}

// As if the loss were that of devices, which does not follow the bus.
std::vector<Level> at_mean_bus(std::vector<Level> levels)
{
    for (Level &level : levels) {
        level.bus_share = 1;
    }
    return levels;
}

// Nothing cools below what it was at the beginning.
bool shows_warming(const Fit &fit)
{
    return fit.value[WARMING] > std::max(WARMING_SEEN, WARMING_SIGMAS * fit.std[WARMING]);
}

} // namespace

double lost_share(double z)
{
    const double size = std::abs(z);
    const double lost = size <= 1 ? size / 2 : 1 - 1 / (2 * size);
    return z < 0 ? -lost : lost;
}

Legs Legs::at_bus(double volts) const
{
    Legs there = *this;
    there.loss_v.value *= volts / bus_v;
    there.bus_v = volts;
    return there;
}

double Legs::lost_v(double leg_a) const
{
    return loss_v.value * lost_share(leg_a / knee_a.value);
}

std::complex<double> Legs::lost_v(std::complex<double> current) const
{
    std::complex<double> lost = 0;
    for (std::size_t leg = 0; leg < LEGS; leg++) {
        lost += TWO_THIRDS * lost_v(on_leg(current, leg)) * LEG_AXIS[leg];
    }
    return lost;
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
    const std::vector<Level> levels = levels_of(records);
    if (levels.size() < LEVELS_MIN) {
        throw ConfigError(
            "the records have too few levels of current at rest: the identification did not come that far");
    }
    const Fit warm = fit_shape(levels, lost_share, PARAMETERS);
    const Parameter parameters = shows_warming(warm) ? PARAMETERS : WARMING;
    const Fit fit = fit_shape(levels, lost_share, parameters);
    const Fit other = fit_shape(levels, other_share, parameters);
    const Fit steady = fit_shape(at_mean_bus(levels), lost_share, parameters);
    Legs legs;
    const auto value = [&](Parameter which) {
        return Value{fit.value[which], fit.std[which],
                     std::abs(fit.value[which] - other.value[which]) / 2 +
                         DROP_OF_LOSS * std::abs(fit.value[which] - steady.value[which])};
    };
    legs.resistance_ohm = value(RESISTANCE);
    legs.loss_v = value(LOSS);
    legs.mismatch = {fit.value[MISMATCH], fit.std[MISMATCH], 0};
    legs.third = {fit.value[THIRD], fit.std[THIRD], 0};
    if (parameters == PARAMETERS) {
        legs.warming = {fit.value[WARMING], fit.std[WARMING], 0};
    } else {
        legs.warming.bound = std::max(warm.value[WARMING], 0.0);
        legs.resistance_ohm.bound += legs.resistance_ohm.value * legs.warming.bound / 2;
    }
    legs.knee_a.value = std::exp(fit.value[LOG_KNEE]);
    legs.knee_a.std = legs.knee_a.value * fit.std[LOG_KNEE];
    legs.bus_v = mean_bus(records);
    legs.period_s = records.scales.period_s;
    legs.largest_a = largest_current(levels);
    add_scale_bounds(legs);
    return legs;
}

void add_ripple_bounds(Legs &legs, double inductance_h)
{
    const double decay = legs.decay(inductance_h);
    const double rippling_v = decay * legs.loss_v.value;
    legs.resistance_ohm.bound += RIPPLE_OF_R * rippling_v / legs.largest_a +
                                 SAMPLE_OF_R * decay * decay * legs.resistance_ohm.value;
    legs.loss_v.bound += RIPPLE_OF_LOSS * rippling_v;
    legs.knee_a.bound += RIPPLE_OF_KNEE * rippling_v / legs.resistance_ohm.value;
}

void add_rounding_bounds(Legs &legs, double shift_a)
{
    legs.resistance_ohm.bound += legs.resistance_ohm.value * shift_a / legs.largest_a;
    legs.loss_v.bound += legs.resistance_ohm.value * shift_a;
    legs.mismatch.bound += shift_a / legs.largest_a;
}

void add_unsure_current(Legs &legs, double share)
{
    const double shift_a = share * legs.largest_a;
    legs.resistance_ohm.bound += legs.resistance_ohm.value * share;
    legs.loss_v.bound += legs.resistance_ohm.value * shift_a / 2;
    legs.knee_a.bound += shift_a / 2;
}

} // namespace nf::identify
