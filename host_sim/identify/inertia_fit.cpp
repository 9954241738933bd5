// SPDX-License-Identifier: MIT
#include "inertia_fit.h"

#include "least_squares.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nf::identify
{
namespace
{

constexpr size_t COASTS_SKIPPED = 1;
constexpr double ONE_PAIR = 0.05; // standard deviation where nothing was repeated
constexpr double UNSEEN = 0.003;  // of J: the speed of the frame is not quite the rotor's when a window begins

// By how much twice the standard deviation of so few values has to be widened to hold 95 of 100: Student's t over 2, near
// enough 1 + 2/(n − 1)^1.3 from three values on.
double student(double count)
{
    return 1 + 2 / std::pow(count - 1, 1.3);
}

bool holds(const Window &window)
{
    return window.kind == "hold" && window.speed_rad_s > 0;
}

// J of a ramp, over its sign of the speed's change: friction that is not known has opposite signs up and down.
double inertia_of(const Window &before, const Window &ramp, const Window &after, int pole_pairs)
{
    const double change = after.speed_rad_s - before.speed_rad_s;
    const double share = (ramp.speed_rad_s - before.speed_rad_s) / change;
    const double friction_nm = before.torque_nm + (after.torque_nm - before.torque_nm) * share;
    return (ramp.torque_nm - friction_nm) * ramp.duration_s * pole_pairs / change;
}

// Of each ramp with the length of the last one, and whether it goes up.
struct Ramp {
    double inertia;
    bool up;
};

std::vector<Ramp> ramps_of(const Records &records)
{
    const std::vector<Window> &all = records.windows;
    const std::vector<Window> ramps = records.of("ramp");
    std::vector<Ramp> found;
    for (size_t k = 1; k + 1 < all.size(); k++) {
        if (all[k].kind == "ramp" && all[k].ticks == ramps.back().ticks && holds(all[k - 1]) &&
            holds(all[k + 1])) {
            found.push_back(
                {inertia_of(all[k - 1], all[k], all[k + 1], records.scales.pole_pairs),
                 all[k + 1].speed_rad_s > all[k - 1].speed_rad_s});
        }
    }
    return found;
}

Friction friction_of(const Fit &fit)
{
    return {{fit.parameters[0], fit.std(0), 0}, {fit.parameters[1], fit.std(1), 0}};
}

} // namespace

Estimate fit_inertia(const Records &records)
{
    const std::vector<Ramp> ramps = ramps_of(records);
    std::vector<double> pairs;
    for (size_t k = 1; k < ramps.size(); k++) {
        if (!ramps[k - 1].up && ramps[k].up) {
            pairs.push_back((ramps[k - 1].inertia + ramps[k].inertia) / 2);
        }
    }
    if (pairs.empty()) {
        throw std::runtime_error("no two ramps of speed, down and up: the inertia is not measured");
    }
    const auto count = static_cast<double>(pairs.size());
    Estimate inertia;
    for (const double pair : pairs) {
        inertia.value += pair / count;
    }
    double square = 0;
    for (const double pair : pairs) {
        square += (pair - inertia.value) * (pair - inertia.value);
    }
    inertia.std = count > 1 ? student(count) * std::sqrt(square / (count - 1) / count)
                            : ONE_PAIR * std::abs(inertia.value);
    inertia.bound = UNSEEN * std::abs(inertia.value);
    return inertia;
}

Friction coasting_friction(const std::vector<Window> &windows, const Scales &scales,
                           const Estimate &inertia)
{
    const size_t first = COASTS_SKIPPED;
    const auto rows = static_cast<Eigen::Index>(windows.size() - first - 1);
    Eigen::MatrixXd a(rows, 2);
    Eigen::VectorXd y(rows);
    for (Eigen::Index k = 0; k < rows; k++) {
        const Window &one = windows[first + static_cast<size_t>(k)];
        const Window &next = windows[first + static_cast<size_t>(k) + 1];
        const double apart_s = (one.duration_s + next.duration_s) / 2;
        const double middle = (one.speed_rad_s * next.duration_s + next.speed_rad_s * one.duration_s) /
                              (one.duration_s + next.duration_s) / scales.pole_pairs;
        const double fall = (one.speed_rad_s - next.speed_rad_s) / scales.pole_pairs;
        a.row(k) = Eigen::RowVector2d(apart_s, apart_s * middle);
        y[k] = inertia.value * fall;
    }
    Friction friction = friction_of(linear_least_squares(a, y));
    const double share = inertia.bar() / inertia.value;
    friction.coulomb_nm.bound = share * std::abs(friction.coulomb_nm.value);
    friction.viscous_nm_s.bound = share * std::abs(friction.viscous_nm_s.value);
    return friction;
}

Friction holding_friction(const Records &records, const Legs &legs)
{
    const std::vector<Window> windows = records.of("hold");
    const auto rows = static_cast<Eigen::Index>(windows.size());
    Eigen::MatrixXd a(rows, 2);
    Eigen::VectorXd y(rows);
    double slowest = HUGE_VAL;
    double current_a = 0;
    for (Eigen::Index k = 0; k < rows; k++) {
        const Window &window = windows[static_cast<size_t>(k)];
        a.row(k) = Eigen::RowVector2d(1, window.speed_rad_s / records.scales.pole_pairs);
        y[k] = torque_of(window, legs.model, records.scales);
        slowest = std::min(slowest, window.speed_rad_s);
        current_a = std::max(current_a, std::abs(window.current_a));
    }
    Friction friction = friction_of(linear_least_squares(a, y));
    const double error_v = legs.resistance_ohm.bar() * current_a + 4.0 / 3 * legs.loss_v.bar();
    const double torque_nm = 1.5 * records.scales.pole_pairs * error_v * current_a / slowest;
    friction.coulomb_nm.bound = torque_nm;
    friction.viscous_nm_s.bound = torque_nm / slowest * records.scales.pole_pairs;
    return friction;
}

} // namespace nf::identify
