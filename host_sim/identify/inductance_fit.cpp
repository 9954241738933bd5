// SPDX-License-Identifier: MIT
#include "inductance_fit.h"

#include "config.h"
#include "least_squares.h"
#include "pulse_model.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace nf::identify
{
namespace
{

constexpr std::size_t BURSTS_MIN = 6;
constexpr int SEARCHES = 30;
constexpr double FOUND = 1e-6;
// What L of the loss is not known: the current ripples, and the edges of the pulses see another current than the mean.
constexpr double LOSS_UNSURE = 0.02;
constexpr double INDUCTANCE_SCALE = 2e-3; // voltage and ripple of the current
// Of the result, found on simulated motors: what the loss and the current's decay in a period make of it.
constexpr double ALONG_UNSURE = 3e-3;
constexpr double ACROSS_LOSS_UNSURE = 0.1;
constexpr double DECAY_UNSURE = 0.04;
// Of 1/L at the continuous current: what the fourth power makes of it, and what as much current along does.
constexpr double QUARTIC_MOST = 0.03;
constexpr double SHARED_MOST = 0.1;

struct Burst {
    bool across = false;
    double bias_a = 0;
    double peak_a = 0;
    double inductance_h = 0;
    double lost_share = 0; // of the pulses' voltage
    double quarter_s = 0;
};

// By the gain of the sensor that sees the pulses.
double measured_change(const Record &r, const Legs &legs)
{
    const double half = legs.mismatch.value / 2;
    const double along[] = {1 + half, 1 - half, 1};
    const double across[] = {1 - half, 1 + half, 1};
    return r.across ? r.change_a.imag() / across[r.axis] : r.change_a.real() / along[r.axis];
}

// The current along. Pulses across change what the legs lose along, and with it that current.
double along_a(const Record &r)
{
    return r.across ? r.i_a.real() : r.current_a;
}

Burst burst_of(const Record &r, const Legs &legs)
{
    const double change = measured_change(r, legs);
    double inductance = r.pulse_v * legs.period_s * r.ticks / change;
    for (int k = 0; k < SEARCHES; k++) {
        const double ratio = modelled_change(r, legs, inductance) / change;
        if (!(ratio > 0)) {
            break;
        }
        inductance *= ratio;
        if (std::abs(ratio - 1) < FOUND) {
            break;
        }
    }
    Burst burst;
    burst.across = r.across;
    burst.bias_a = along_a(r);
    burst.peak_a = change / r.ticks * r.quarter_ticks;
    burst.inductance_h = inductance;
    burst.lost_share = legs.loss_v.value / r.pulse_v;
    burst.quarter_s = r.quarter_ticks * legs.period_s;
    return burst;
}

// How far the L of a burst may be off, a share of it: what the legs lose of small pulses is not known well.
double unsure_of(const Burst &burst)
{
    return INDUCTANCE_SCALE + LOSS_UNSURE * burst.lost_share;
}

// L0/L of the bursts over the columns that `row` makes of each, every row by how sure it is. Behind them stand what is known
// of iron beforehand, column by column: 0, to about so much; 0: nothing is.
Fit fit_inverse(const std::vector<Burst> &bursts, const std::vector<double> &expected,
                const std::function<std::vector<double>(const Burst &)> &row_of)
{
    const auto count = static_cast<Eigen::Index>(bursts.size());
    const auto columns = static_cast<Eigen::Index>(expected.size());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count + columns, columns);
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(count + columns);
    for (Eigen::Index k = 0; k < count; k++) {
        const Burst &burst = bursts[static_cast<std::size_t>(k)];
        const std::vector<double> row = row_of(burst);
        rows.row(k) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), columns) / unsure_of(burst);
        inverse[k] = bursts.front().inductance_h / burst.inductance_h / unsure_of(burst);
    }
    for (Eigen::Index k = 0; k < columns; k++) {
        const double most = expected[static_cast<std::size_t>(k)];
        rows(count + k, k) = most > 0 ? 1 / most : 0;
    }
    return fit_linear(rows, inverse);
}

// Along: a parabola over the bias.
Fit fit_along(const std::vector<Burst> &bursts, double scale_a)
{
    return fit_inverse(bursts, {0, 0, 0}, [&](const Burst &b) {
        const double x = b.bias_a / scale_a;
        return std::vector<double>{1, x, x * x};
    });
}

// Across: over even powers of the pulses' current, and over the current along: at rest some is needed to hold the rotor, and
// it saturates the iron too.
Fit fit_across(const std::vector<Burst> &bursts, double scale_a)
{
    return fit_inverse(bursts, {0, 0, QUARTIC_MOST, SHARED_MOST}, [&](const Burst &b) {
        const double square = std::pow(b.peak_a / scale_a, 2);
        return std::vector<double>{1, square, square * square, b.bias_a / scale_a};
    });
}

double largest(const std::vector<Burst> &bursts, double Burst::*field)
{
    double most = 0;
    for (const Burst &burst : bursts) {
        most = std::max(most, burst.*field);
    }
    return most;
}

double mean_lost(const std::vector<Burst> &bursts)
{
    double sum = 0;
    for (const Burst &burst : bursts) {
        sum += burst.lost_share;
    }
    return sum / static_cast<double>(bursts.size());
}

// Of a fit's share L0/L. unsure: of the whole, a share.
Value value_of(double inductance_h, double share, double std, double unsure)
{
    const double inductance = inductance_h / share;
    return {inductance, inductance * std / share, inductance * unsure};
}

} // namespace

Inductances fit_inductances(const Records &records, const Legs &legs, double current_a)
{
    std::vector<Burst> along;
    std::vector<Burst> across;
    for (const Record &record : records.of("burst")) {
        if (record.pulse_v > 0 && measured_change(record, legs) > 0) {
            const Burst burst = burst_of(record, legs);
            (burst.across ? across : along).push_back(burst);
        }
    }
    if (along.size() < BURSTS_MIN || across.size() < BURSTS_MIN) {
        throw ConfigError(
            "the records have too few pulses at rest: the identification did not come that far");
    }
    Inductances found;
    found.current_a = std::min(current_a, largest(across, &Burst::peak_a));
    found.quarter_s = largest(across, &Burst::quarter_s);
    const Fit d = fit_along(along, found.current_a);
    const Fit q = fit_across(across, found.current_a);
    const double decay = legs.resistance_ohm.value * legs.period_s / along.front().inductance_h;
    found.d_h = value_of(along.front().inductance_h, d.value[0], d.std[0],
                         ALONG_UNSURE + LOSS_UNSURE * mean_lost(along));
    found.q_h = value_of(across.front().inductance_h, q.value[0] + q.value[1] + q.value[2],
                         q.std[0], ACROSS_LOSS_UNSURE * mean_lost(across) + DECAY_UNSURE * decay);
    return found;
}

} // namespace nf::identify
