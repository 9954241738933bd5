// SPDX-License-Identifier: MIT
#include "inductance_fit.h"

#include "config.h"
#include "least_squares.h"

#include <algorithm>
#include <cmath>

namespace nf::identify
{
namespace
{

constexpr std::size_t BURSTS_MIN = 6;
constexpr int SUBSTEPS = 4;
constexpr int SEARCHES = 30;
constexpr double FOUND = 1e-6;
constexpr double QUARTERS = 4;
// What L of the loss is not known: the current ripples, and the edges of the pulses see another current than the mean.
constexpr double LOSS_UNSURE = 0.02;
constexpr double INDUCTANCE_SCALE = 2e-3; // voltage and ripple of the current

struct Burst {
    bool across = false;
    double bias_a = 0;
    double peak_a = 0;
    double inductance_h = 0;
    double lost_share = 0; // of the pulses' voltage
    double quarter_s = 0;
};

// The pulse's sign in a tick: +, −, −, + for a quarter each.
double sign_of(int tick, int quarter)
{
    const int part = (tick / quarter) % 4;
    return part == 1 || part == 2 ? -1 : 1;
}

// The sum of the changes, each with its pulse's sign, of a winding with this inductance.
double modelled_change(const Record &r, const Legs &legs, double inductance_h)
{
    const std::complex<double> direction = r.across ? std::complex<double>(0, 1) : 1.0;
    const std::complex<double> bias = r.current_a;
    const double resistance = legs.resistance_ohm.value;
    const double step_s = legs.period_s / SUBSTEPS;
    // of the current to a volt in a step, with the resistance exactly
    const double answer = -std::expm1(-resistance * step_s / inductance_h) / resistance;
    const double held_v = (legs.lost_v(bias) * std::conj(direction)).real() +
                          resistance * (bias * std::conj(direction)).real();
    double i = (bias * std::conj(direction)).real();
    const std::complex<double> rest = r.across ? bias : 0.0;
    double sum = 0;
    for (int tick = 0; tick < static_cast<int>(r.ticks); tick++) {
        const double sign = sign_of(tick, r.quarter_ticks);
        const double before = i;
        for (int k = 0; k < SUBSTEPS; k++) {
            const double lost = (legs.lost_v(rest + direction * i) * std::conj(direction)).real();
            i += (sign * r.pulse_v + held_v - lost - resistance * i) * answer;
        }
        sum += sign * (i - before);
    }
    return sum;
}

// By the gain of the sensor that sees the pulses.
double measured_change(const Record &r, const Legs &legs)
{
    const double half = legs.mismatch.value / 2;
    const double along[] = {1 + half, 1 - half, 1};
    const double across[] = {1 - half, 1 + half, 1};
    return r.across ? r.change_a.imag() / across[r.axis] : r.change_a.real() / along[r.axis];
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
    burst.bias_a = r.current_a;
    burst.peak_a = change / r.ticks * r.quarter_ticks;
    burst.inductance_h = inductance;
    burst.lost_share = legs.loss_v.value / r.pulse_v;
    burst.quarter_s = r.quarter_ticks * legs.period_s;
    return burst;
}

// 1/L over the powers of a regressor up to `order`, and the scatter.
Fit fit_inverse(const std::vector<Burst> &bursts, int order, double (*regressor)(const Burst &))
{
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(bursts.size()), order + 1);
    Eigen::VectorXd inverse(rows.rows());
    for (Eigen::Index k = 0; k < rows.rows(); k++) {
        const Burst &burst = bursts[static_cast<std::size_t>(k)];
        for (int power = 0; power <= order; power++) {
            rows(k, power) = std::pow(regressor(burst), power);
        }
        inverse[k] = 1 / burst.inductance_h;
    }
    return fit_linear(rows, inverse);
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

// What is not known of 1/L: the scatter of the three axes is no noise that many bursts average out.
Value value_of(const Fit &fit, double inverse, double lost_share)
{
    const double inductance = 1 / inverse;
    return {inductance, inductance * fit.std[0] / inverse / 2,
            inductance * (INDUCTANCE_SCALE + LOSS_UNSURE * lost_share)};
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
    const Fit d = fit_inverse(along, 2, [](const Burst &b) { return b.bias_a; });
    const Fit q = fit_inverse(across, 1, [](const Burst &b) { return b.peak_a * b.peak_a; });
    Inductances found;
    found.current_a = std::min(current_a, largest(across, &Burst::peak_a));
    found.quarter_s = largest(across, &Burst::quarter_s);
    found.d_slope = d.value[1];
    found.q_bend = q.value[1];
    found.d_h = value_of(d, d.value[0], mean_lost(along));
    found.q_h =
        value_of(q, q.value[0] + q.value[1] * found.current_a * found.current_a, mean_lost(across));
    return found;
}

} // namespace nf::identify
