// SPDX-License-Identifier: MIT
#include "speed_margin.h"

#include "nn_observer_units.h"
#include "si.h"
#include "torque_filter_units.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace nf
{
namespace
{

using Complex = std::complex<double>;

constexpr double PWM_DELAY = 1.5;   // periods from the samples to the middle of the voltage
constexpr double HUNDREDFOLD = 100; // range of frequencies in which a loop may lag by half a turn
constexpr int HALVINGS = 50;        // of a range in which a frequency is sought

// Where the gain of (2ζw·s + w²)/s² is 1, in w.
double crossover_share(double damping)
{
    const double square = damping * damping;
    return std::sqrt(2 * square + std::sqrt(4 * square * square + 1));
}

// The largest x in 0…most for which `holds`, which does up to there.
template <typename Holds> double last(double most, Holds holds)
{
    double low = 0;
    double high = most;
    for (int k = 0; k < HALVINGS; k++) {
        const double middle = (low + high) / 2;
        (holds(middle) ? low : high) = middle;
    }
    return low;
}

// ω̂ over ω: the law of second order that κ and κ_p make.
Complex estimate(const TuningSettings &tuning, double period_s, Complex s)
{
    const double lag = estimate_lag_s(tuning, period_s);
    return lag > 0 ? 1.0 / (1.0 + s * lag + s * s * period_s * period_s / tuning.observer_kappa)
                   : 1.0;
}

// The open loop at `hz`.
Complex open_loop(const TuningSettings &tuning, double period_s, double bandwidth_hz,
                  TorqueFilter filter, double hz)
{
    const Complex s(0, TWO_PI * hz);
    const double w = TWO_PI * bandwidth_hz;
    const double held = (tuning.slow_ticks / 2.0 + PWM_DELAY) * period_s;
    const Complex current = 1.0 / (1.0 + s / (TWO_PI * tuning.current_bandwidth_hz));
    const Complex design = (2 * tuning.speed_damping * w * s + w * w) / (s * s);
    const Complex filtered =
        filter == TorqueFilter::as_set
            ? torque_filter_response(tuning, speed_loop_rate(tuning, period_s), hz)
            : 1.0;
    return design * estimate(tuning, period_s, s) * current * std::exp(-s * held) * filtered;
}

} // namespace

double speed_margin(const TuningSettings &tuning, double control_period_s, double bandwidth_hz,
                    TorqueFilter filter)
{
    const double most_hz = crossover_share(tuning.speed_damping) * bandwidth_hz;
    const bool notched = filter == TorqueFilter::as_set && tuning.notch_hz > 0;
    if (notched && tuning.notch_hz <= most_hz) {
        return -PI;
    }
    const auto at = [&](double hz) {
        return open_loop(tuning, control_period_s, bandwidth_hz, filter, hz);
    };
    const Complex crossing = at(last(most_hz, [&](double hz) { return std::abs(at(hz)) >= 1; }));
    return std::arg(-crossing);
}

double speed_lag_hz(const TuningSettings &tuning, double control_period_s)
{
    constexpr double STEP = 1.01;
    const double end_hz = speed_loop_rate(tuning, control_period_s) / 2;
    double hz = end_hz / std::pow(STEP, std::ceil(std::log(HUNDREDFOLD) / std::log(STEP)));
    const auto leads = [&](double at_hz) {
        return std::arg(-open_loop(tuning, control_period_s, tuning.speed_bandwidth_hz,
                                   TorqueFilter::as_set, at_hz)) > 0;
    };
    while (hz < end_hz && !leads(hz)) { // a loop whose integral part alone lags so
        hz *= STEP;
    }
    while (hz < end_hz && leads(hz)) {
        hz *= STEP;
    }
    return std::min(hz, end_hz);
}

double bandwidth_of_margin(const TuningSettings &tuning, double control_period_s, double margin,
                           double most_hz)
{
    const auto holds = [&](double hz) {
        return speed_margin(tuning, control_period_s, hz, TorqueFilter::as_set) >= margin;
    };
    return holds(most_hz) ? most_hz : last(most_hz, holds);
}

} // namespace nf
