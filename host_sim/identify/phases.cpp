// SPDX-License-Identifier: MIT
#include "phases.h"

#include <algorithm>
#include <cmath>

namespace nf::identify
{
namespace
{

constexpr double PHASE_SIGMAS = 4;
// Of an axis: what three like phases may differ by, as the converters' steps and the position of
// the rotor do not repeat.
constexpr double RESISTANCE_ALIKE = 4e-3;
constexpr double INDUCTANCE_ALIKE = 6e-3;

// a over b of two values whose mean is 1 and that differ by this.
Value ratio_of(const Value &difference)
{
    const double half = difference.value / 2;
    const double slope = 1 / ((1 - half) * (1 - half));
    return {(1 + half) / (1 - half) - 1, difference.std * slope, difference.bound * slope};
}

// Of an axis over the mean, less one, and of its phase over the other two: the axis has half of the
// phase, and the others half of the rest.
double of_phase(double axis_share)
{
    const double phase = 2 * axis_share;
    return 1.5 * phase / (1 - phase / 2);
}

} // namespace

Phases fit_phases(const Legs &legs, const Inductances &inductances)
{
    const AxisShares &axes = inductances.axes;
    const double apart = axes.share[0] - axes.share[1];
    const double unsure = PHASE_SIGMAS * axes.std + INDUCTANCE_ALIKE;
    const bool turns_differ = std::abs(axes.share[2]) > unsure;
    const bool gains_differ = std::abs(apart) > std::sqrt(3) * unsure;
    const bool third_differs =
        std::abs(legs.third.value) > PHASE_SIGMAS * legs.third.std + RESISTANCE_ALIKE;
    Phases phases;
    Value difference = legs.mismatch;
    phases.are_unlike = turns_differ || gains_differ || third_differs;
    if (phases.are_unlike) {
        const double r_apart = turns_differ ? apart : -apart;
        const double r_axis[] = {(r_apart - legs.third.value) / 2,
                                 (-r_apart - legs.third.value) / 2, legs.third.value};
        const double l_apart = turns_differ ? 2 * apart : 0;
        const double l_axis[] = {(l_apart - axes.share[2]) / 2, (-l_apart - axes.share[2]) / 2,
                                 axes.share[2]};
        const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
        phases.phase = static_cast<int>(std::max_element(r_axis, r_axis + 3, smaller) - r_axis);
        phases.resistance_share = of_phase(r_axis[phases.phase]);
        phases.inductance_share = turns_differ ? of_phase(l_axis[phases.phase]) : 0;
        difference.value += r_apart;
        difference.bound += std::abs(apart) / 2 + unsure;
    } else {
        difference.bound += std::abs(apart); // too little to be told from gains
    }
    phases.mismatch = ratio_of(difference);
    return phases;
}

} // namespace nf::identify
