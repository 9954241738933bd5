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
// How bursts weigh against each other. What L of the loss is not known: the current ripples, and
// the edges of the pulses see another current than the mean. Small pulses across let the current of
// a leg cross zero within a period, where its loss turns over: of second order in the loss, once in
// a quarter.
constexpr double INDUCTANCE_SCALE = 2e-3; // voltage and ripple of the current
constexpr double LOSS_UNSURE = 0.02;
constexpr double CROSSING_UNSURE = 2;
// Bounds of the results: of the voltage's scale and the ripple; of the loss; of a current that
// crosses zero; of the decay of the current in a period, and of the loss that moves the edges
// between which it decays. Their sizes were found on simulated motors.
constexpr double SCALE_BOUND = 2e-3;
constexpr double ALONG_LOSS_BOUND = 0.015;
constexpr double ACROSS_LOSS_BOUND = 0.02;
constexpr double CROSSING_BOUND = 0.5;
constexpr double DECAY_BOUND = 0.04;
constexpr double DECAY_LOSS_BOUND = 0.2;
// Added between the currents: what the curves do not follow.
constexpr double CURVE_BOUND = 2e-3;
// Of 1/L at the continuous current: what the fourth power makes of it, and what as much current
// along does.
constexpr double QUARTIC_MOST = 0.03;
constexpr double SHARED_MOST = 0.1;
// Of slow over fast pulses: they agree without a low pass of the sensors. Of the loss and the decay
// in a period likewise.
constexpr double LAG_SCALE = 2e-3;
constexpr double LAG_LOSS_UNSURE = 0.025;
constexpr double LAG_DECAY_UNSURE = 0.05;
constexpr double LAG_SIGMAS = 3;
constexpr double LAG_FIRST = 1.0 / 32; // of a period
constexpr double LAG_MOST = 8;
constexpr int LAG_SEARCHES = 12;
// Of 1/L across: what slow pulses may have more of it without a rotor that they turn.
constexpr double SWING_SEEN = 1.5; // over that
constexpr double SWING_SIGMAS = 3;
constexpr double LAG_OF_SWING = 0.25; // of what the correction of a low pass takes from it
constexpr double SWING_SCALE = 3e-3;
constexpr double SWING_LOSS_UNSURE = 0.06;
constexpr double SWING_DECAY_UNSURE = 0.02;
constexpr double PULSES[] = {6.0 / 16, 11.0 / 16, 1}; // across, of their largest: aim_burst()

struct Burst {
    bool across = false;
    double bias_a = 0;
    double peak_a = 0;
    double inductance_h = 0;
    double lost_share = 0; // of the pulses' voltage
    int axis = 0;
    double quarter_s = 0;
    double period_s = 0;
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

// Pulses across turn the rotor a little, and over a whole pattern its EMF helps them: with dω/dt =
// 1.5·P²·φ/J·i the change of the current is larger by a third of 1.5·P²·φ²/J·t²/L in quarters of t.
double with_still_rotor(double inductance_h, double quarter_s, double rotor_h_s2)
{
    return inductance_h + rotor_h_s2 * quarter_s * quarter_s / 3;
}

// What a burst shows beside L.
struct Beside {
    double sensor_lag_s = 0;
    double rotor_h_s2 = 0;
};

Burst burst_of(const Record &r, const Legs &at_rest, const Beside &beside)
{
    const Legs legs = at_rest.at_bus(r.bus_v);
    const double change = measured_change(r, legs);
    double inductance = r.pulse_v * legs.period_s * r.ticks / change;
    for (int k = 0; k < SEARCHES; k++) {
        const double ratio = modelled_change(r, legs, inductance, beside.sensor_lag_s) / change;
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
    burst.axis = r.axis;
    burst.bias_a = along_a(r);
    burst.peak_a = change / r.ticks * r.quarter_ticks;
    burst.lost_share = legs.loss_v.value / r.pulse_v;
    burst.quarter_s = r.quarter_ticks * legs.period_s;
    burst.period_s = legs.period_s;
    burst.inductance_h =
        with_still_rotor(inductance, burst.quarter_s, r.across ? beside.rotor_h_s2 : 0);
    return burst;
}

// The square of the loss in those periods of a burst across in which a current crosses zero.
double crossing(const Burst &burst)
{
    return burst.lost_share * burst.lost_share * burst.period_s / burst.quarter_s;
}

// How far the L of a burst may be off, a share of it.
double unsure_of(const Burst &burst)
{
    return INDUCTANCE_SCALE + LOSS_UNSURE * burst.lost_share +
           (burst.across ? CROSSING_UNSURE * crossing(burst) : 0);
}

// A share of L across. burst: with pulses of that current; decay: of the current in a period.
double across_bound(const Burst &burst, double decay)
{
    return SCALE_BOUND + ACROSS_LOSS_BOUND * burst.lost_share + CROSSING_BOUND * crossing(burst) +
           decay * (DECAY_BOUND + DECAY_LOSS_BOUND * burst.lost_share);
}

// L0/L of the bursts over the columns that `row` makes of each, every row by how sure it is. Behind
// them stand what is known of iron beforehand, column by column: 0, to about so much; 0: nothing
// is.
Fit fit_inverse(const std::vector<Burst> &bursts, const std::vector<double> &expected,
                const std::function<std::vector<double>(const Burst &)> &row_of)
{
    const auto count = static_cast<Eigen::Index>(bursts.size());
    const auto columns = static_cast<Eigen::Index>(expected.size());
    const auto known =
        std::count_if(expected.begin(), expected.end(), [](double m) { return m > 0; });
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count + known, columns);
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(count + known);
    for (Eigen::Index k = 0; k < count; k++) {
        const Burst &burst = bursts[static_cast<std::size_t>(k)];
        const std::vector<double> row = row_of(burst);
        rows.row(k) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), columns) / unsure_of(burst);
        inverse[k] = bursts.front().inductance_h / burst.inductance_h / unsure_of(burst);
    }
    Eigen::Index below = count;
    for (Eigen::Index k = 0; k < columns; k++) {
        const double most = expected[static_cast<std::size_t>(k)];
        if (most > 0) {
            rows(below++, k) = 1 / most;
        }
    }
    return fit_linear(rows, inverse);
}

// Along: a parabola over the bias. The first value is that at the current `at_a`, and so is its
// standard deviation.
Fit fit_along(const std::vector<Burst> &bursts, double scale_a, double at_a)
{
    const double at = at_a / scale_a;
    return fit_inverse(bursts, {0, 0, 0}, [&](const Burst &b) {
        const double x = b.bias_a / scale_a;
        return std::vector<double>{1, x - at, x * x - at * at};
    });
}

// Across: over even powers of the pulses' current, and over the current along: at rest some is
// needed to hold the rotor, and it saturates the iron too. The first value is that for pulses of
// `at_a` without it.
Fit fit_across(const std::vector<Burst> &bursts, double scale_a, double at_a)
{
    const double at = std::pow(at_a / scale_a, 2);
    return fit_inverse(bursts, {0, 0, QUARTIC_MOST, SHARED_MOST}, [&](const Burst &b) {
        const double square = std::pow(b.peak_a / scale_a, 2);
        return std::vector<double>{1, square - at, square * square - at * at, b.bias_a / scale_a};
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
Value value_of(double inductance_h, const Fit &fit, double unsure)
{
    const double share = fit.value[0];
    const double inductance = inductance_h / share;
    return {inductance, inductance * fit.std[0] / share, inductance * unsure};
}

struct Bursts {
    std::vector<Burst> along;
    std::vector<Burst> across;
};

Bursts bursts_of(const Records &records, const Legs &legs, const Beside &beside)
{
    Bursts bursts;
    for (const Record &record : records.of("burst")) {
        if (record.pulse_v > 0 && measured_change(record, legs) > 0) {
            const Burst burst = burst_of(record, legs, beside);
            (burst.across ? bursts.across : bursts.along).push_back(burst);
        }
    }
    if (bursts.along.size() < BURSTS_MIN || bursts.across.size() < BURSTS_MIN) {
        throw ConfigError(
            "the records have too few pulses at rest: the identification did not come that far");
    }
    return bursts;
}

// The currents along, each once, from the smallest on.
std::vector<double> biases_of(const std::vector<Burst> &along)
{
    std::vector<double> biases;
    biases.reserve(along.size());
    for (const Burst &burst : along) {
        biases.push_back(burst.bias_a);
    }
    std::sort(biases.begin(), biases.end());
    biases.erase(std::unique(biases.begin(), biases.end()), biases.end());
    return biases;
}

const Burst &nearest(const std::vector<Burst> &across, double peak_a)
{
    return *std::min_element(across.begin(), across.end(), [&](const Burst &a, const Burst &b) {
        return std::abs(a.peak_a - peak_a) < std::abs(b.peak_a - peak_a);
    });
}

Value between(Value value)
{
    value.bound += CURVE_BOUND * value.value;
    return value;
}

// Of both axes, with what else shows in a burst.
Inductances fit_with(const Bursts &bursts, const Legs &legs, double current_a)
{
    const auto &[along, across] = bursts;
    Inductances found;
    found.current_a = std::min(current_a, largest(across, &Burst::peak_a));
    const double d_h = along.front().inductance_h;
    const double q_h = across.front().inductance_h;
    const double decay = legs.decay(q_h);
    const double unsure_d = SCALE_BOUND + ALONG_LOSS_BOUND * mean_lost(along);
    const auto d_at = [&, &those = along](double at_a) {
        return value_of(d_h, fit_along(those, found.current_a, at_a), unsure_d);
    };
    const auto q_at = [&, &those = across](double at_a) {
        const double unsure = across_bound(nearest(those, at_a), decay);
        return value_of(q_h, fit_across(those, found.current_a, at_a), unsure);
    };
    found.d_h = d_at(0);
    found.q_h = q_at(found.current_a);
    for (const double bias_a : biases_of(along)) {
        found.d_over_current.push_back({bias_a, between(d_at(bias_a))});
    }
    for (const double share : PULSES) {
        const double at_a = share * found.current_a;
        found.q_over_current.push_back({at_a, between(q_at(at_a))});
    }
    return found;
}

// Two bursts along the same current: one takes half of the voltage for twice as many ticks.
struct BurstPair {
    Record fast;
    Record slow;
};

std::vector<BurstPair> pairs_along(const Records &records)
{
    const std::vector<Record> bursts = records.of("burst");
    std::vector<BurstPair> pairs;
    for (std::size_t k = 0; k + 1 < bursts.size(); k++) {
        const Record &fast = bursts[k];
        const Record &slow = bursts[k + 1];
        const bool same = fast.current_a == slow.current_a && fast.axis == slow.axis;
        const bool along = !fast.across && !slow.across && fast.pulse_v > 0 && slow.pulse_v > 0;
        const bool changes = fast.change_a.real() > 0 && slow.change_a.real() > 0;
        if (along && same && changes && slow.quarter_ticks == 2 * fast.quarter_ticks) {
            pairs.push_back({fast, slow});
        }
    }
    return pairs;
}

// How much more L the slow ones have of the pairs, as a logarithm: nothing, with the right time
// constant of the sensors.
struct SlowOverFast {
    double mean = 0;
    double std = 0;    // of it
    double unsure = 0; // of what repeats itself
};

SlowOverFast slow_over_fast(const std::vector<BurstPair> &pairs, const Legs &legs, double lag_s)
{
    const Beside beside{lag_s, 0};
    const auto count = static_cast<double>(pairs.size());
    double sum = 0;
    double squares = 0;
    SlowOverFast found;
    for (const BurstPair &pair : pairs) {
        const Burst fast = burst_of(pair.fast, legs, beside);
        const Burst slow = burst_of(pair.slow, legs, beside);
        const double more = std::log(slow.inductance_h / fast.inductance_h);
        sum += more;
        squares += more * more;
        found.unsure = LAG_SCALE + LAG_LOSS_UNSURE * fast.lost_share +
                       LAG_DECAY_UNSURE * legs.decay(fast.inductance_h);
    }
    found.mean = sum / count;
    found.std = std::sqrt(std::max(squares / count - found.mean * found.mean, 0.0) / (count - 1));
    return found;
}

// The shortest time constant with which slow pulses have so much more L; LAG_MOST at most.
double lag_for(double more, const std::vector<BurstPair> &pairs, const Legs &legs)
{
    double low = 0;
    double high = LAG_FIRST * legs.period_s;
    while (high < LAG_MOST * legs.period_s && slow_over_fast(pairs, legs, high).mean < more) {
        low = high;
        high *= 2;
    }
    for (int k = 0; k < LAG_SEARCHES; k++) {
        const double middle = (low + high) / 2;
        (slow_over_fast(pairs, legs, middle).mean < more ? low : high) = middle;
    }
    return (low + high) / 2;
}

// A low pass lets pulses seem smaller, those most that change most often.
SensorLag fit_lag(const Records &records, const Legs &legs)
{
    const std::vector<BurstPair> pairs = pairs_along(records);
    SensorLag lag;
    if (pairs.size() < 2) {
        return lag;
    }
    const SlowOverFast without = slow_over_fast(pairs, legs, 0);
    const double unsure = LAG_SIGMAS * without.std + without.unsure;
    if (-without.mean < unsure) {
        lag.hidden_s = without.mean < without.std ? lag_for(without.std, pairs, legs) : 0;
        return lag;
    }
    lag.s.value = lag_for(0, pairs, legs);
    lag.s.bound = lag_for(unsure, pairs, legs) - lag.s.value;
    return lag;
}

// How much further a rotor turns under the pulses than what is known of it says.
struct Swing {
    double more_h_s2 = 0;
    double std_h_s2 = 0;
    double unsure_h_s2 = 0; // with what repeats itself
};

// It is what 1/L across has of the square of the quarter, at the current at_a.
Swing fit_swing(const std::vector<Burst> &across, const Legs &legs, double at_a)
{
    const double longest_s = largest(across, &Burst::quarter_s);
    const double q_h = across.front().inductance_h;
    const Fit fit = fit_inverse(across, {0, 0, QUARTIC_MOST, SHARED_MOST, 0}, [&](const Burst &b) {
        const double square = std::pow(b.peak_a / at_a, 2);
        return std::vector<double>{1, square - 1, square * square - 1, b.bias_a / at_a,
                                   std::pow(b.quarter_s / longest_s, 2)};
    });
    const double unsure = SWING_SIGMAS * fit.std[4] + SWING_SCALE +
                          SWING_LOSS_UNSURE * mean_lost(across) +
                          SWING_DECAY_UNSURE * legs.decay(q_h);
    const double to_h_s2 = 3 * q_h / (longest_s * longest_s);
    return {fit.value[4] * to_h_s2, fit.std[4] * to_h_s2, unsure * to_h_s2};
}

// As if the sensors had no low pass, which slow pulses show like a rotor that turns.
double swing_without_lag(const Records &records, const Legs &legs, const Beside &beside,
                         double at_a)
{
    const Bursts bursts = bursts_of(records, legs, {0, beside.rotor_h_s2});
    return fit_swing(bursts.across, legs, at_a).more_h_s2;
}

// The bursts of each axis are the same ones.
AxisShares axes_of(const std::vector<Burst> &along)
{
    AxisShares axes;
    double sum[3] = {0, 0, 0};
    double count[3] = {0, 0, 0};
    for (const Burst &burst : along) {
        sum[burst.axis] += std::log(burst.inductance_h);
        count[burst.axis] += 1;
    }
    if (count[0] != count[1] || count[1] != count[2]) {
        return axes;
    }
    const double mean = (sum[0] + sum[1] + sum[2]) / (3 * count[0]);
    for (int axis = 0; axis < 3; axis++) {
        axes.share[axis] = sum[axis] / count[axis] - mean;
    }
    double squares = 0;
    const auto each = along.size() / 3;
    for (std::size_t k = 0; k < each; k++) {
        const double a = std::log(along[k].inductance_h) - axes.share[along[k].axis];
        const double b = std::log(along[k + each].inductance_h) - axes.share[along[k + each].axis];
        const double c =
            std::log(along[k + 2 * each].inductance_h) - axes.share[along[k + 2 * each].axis];
        const double middle = (a + b + c) / 3;
        squares += std::pow(a - middle, 2) + std::pow(b - middle, 2) + std::pow(c - middle, 2);
    }
    axes.std = std::sqrt(squares / (2 * static_cast<double>(each * each)));
    return axes;
}

// What differs between two evaluations of the same bursts is a bound of both.
void add_difference(Inductances &found, const Inductances &other)
{
    found.d_h.bound += std::abs(found.d_h.value - other.d_h.value);
    found.q_h.bound += std::abs(found.q_h.value - other.q_h.value);
    for (std::size_t k = 0; k < found.d_over_current.size(); k++) {
        Value &h = found.d_over_current[k].h;
        h.bound += std::abs(h.value - other.d_over_current[k].h.value);
    }
    for (std::size_t k = 0; k < found.q_over_current.size(); k++) {
        Value &h = found.q_over_current[k].h;
        h.bound += std::abs(h.value - other.q_over_current[k].h.value);
    }
}

} // namespace

Inductances fit_inductances(const Records &records, const Legs &legs, double current_a,
                            const Turned &turned)
{
    const SensorLag lag = fit_lag(records, legs);
    Beside beside{lag.s.value, turned.rotor_h_s2};
    Bursts bursts = bursts_of(records, legs, beside);
    const double most_a = std::min(current_a, largest(bursts.across, &Burst::peak_a));
    const Swing swing = fit_swing(bursts.across, legs, most_a);
    const double corrected_h_s2 =
        lag.s.value > 0 ? swing_without_lag(records, legs, beside, most_a) - swing.more_h_s2 : 0;
    const double unsure_h_s2 = swing.unsure_h_s2 + LAG_OF_SWING * std::abs(corrected_h_s2);
    const double least_h_s2 = turned.load_swings ? 0 : SWING_SEEN * unsure_h_s2;
    const bool swings = turned.rotor_h_s2 > 0 && swing.more_h_s2 > least_h_s2;
    const bool may_swing = turned.rotor_h_s2 > 0 && swing.more_h_s2 > swing.std_h_s2;
    if (swings) {
        beside.rotor_h_s2 += swing.more_h_s2;
        bursts = bursts_of(records, legs, beside);
    }
    Inductances found = fit_with(bursts, legs, current_a);
    // What may be there without being told from chance is a bound.
    Beside other{lag.s.value + lag.s.bound + lag.hidden_s, beside.rotor_h_s2};
    if (swings) {
        other.rotor_h_s2 += unsure_h_s2;
    } else if (may_swing) {
        other.rotor_h_s2 += swing.more_h_s2;
    } else {
        // as much as is known
    }
    add_difference(found, fit_with(bursts_of(records, legs, other), legs, current_a));
    found.alone_h_s2 = swings ? beside.rotor_h_s2 : 0;
    found.axes = axes_of(bursts.along);
    found.lag = lag;
    return found;
}

} // namespace nf::identify
