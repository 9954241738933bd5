// SPDX-License-Identifier: MIT
#include "stability.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

namespace nf::design
{
namespace
{

constexpr double KI_SMALLEST_PER_S = 1e-4; // well below the paper's 0.035
constexpr double KI_LARGEST_PER_S = 1e6;
constexpr double KI_STEP = 1.25; // the edge is bracketed in steps of this ratio
constexpr double KP_FAR = 1e3;   // |K_p| beyond it is not looked at
constexpr double KP_FIRST = 0.01;
constexpr int EDGE_STEPS = 45; // a bracket of 1 ends below 1e-13

// Between `good`, where `holds`, and `bad`, where it does not.
double edge(double good, double bad, const std::function<bool(double)> &holds)
{
    for (int k = 0; k < EDGE_STEPS; k++) {
        const double middle = (good + bad) / 2;
        (holds(middle) ? good : bad) = middle;
    }
    return good;
}

// The last K_p in a direction (±1) with a stable K_i.
double last_kp(const Discrete &motor, double inside_kp, double direction)
{
    const auto holds = [&](double kp) { return is_stable(motor, {kp, KI_SMALLEST_PER_S}); };
    double step = KP_FIRST;
    while (step < KP_FAR && holds(inside_kp + direction * step)) {
        step *= 2;
    }
    return edge(inside_kp, inside_kp + direction * step, holds);
}

} // namespace

std::vector<std::complex<double>> poles(const Eigen::MatrixXd &a)
{
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(a, false);
    std::vector<std::complex<double>> values(solver.eigenvalues().begin(),
                                             solver.eigenvalues().end());
    std::sort(values.begin(), values.end(),
              [](const auto &x, const auto &y) { return std::abs(x) > std::abs(y); });
    return values;
}

std::complex<double> slowest_pole(const Discrete &motor, const Gains &gains)
{
    return poles(close_loop(motor, gains).a).front();
}

bool is_stable(const Discrete &motor, const Gains &gains)
{
    return std::abs(slowest_pole(motor, gains)) < 1;
}

double time_constant_s(double magnitude, double sample_time_s)
{
    return -sample_time_s / std::log(magnitude);
}

void require_stable(const Discrete &motor, const Gains &gains, const std::string &what)
{
    const std::complex<double> pole = slowest_pole(motor, gains);
    if (std::abs(pole) < 1) {
        return;
    }
    const std::string imaginary =
        pole.imag() == 0 ? "" : fmt::format(" ± {:.6g}i", std::abs(pole.imag()));
    throw UnstableError(fmt::format("{}: K_p = {:.6g}, K_i = {:.6g} 1/s: is unstable, eigenvalue "
                                    "{:.7g}{} has magnitude {:.7g}; allowed: below 1",
                                    what, gains.kp, gains.ki_per_s, pole.real(), imaginary,
                                    std::abs(pole)));
}

std::optional<double> largest_ki_per_s(const Discrete &motor, double kp)
{
    const auto holds = [&](double ki) { return is_stable(motor, {kp, ki}); };
    if (!holds(KI_SMALLEST_PER_S)) {
        return std::nullopt;
    }
    double ki = KI_SMALLEST_PER_S;
    while (ki < KI_LARGEST_PER_S && holds(ki * KI_STEP)) {
        ki *= KI_STEP;
    }
    return edge(ki, ki * KI_STEP, holds);
}

Region stable_region(const Discrete &motor, double inside_kp, int points)
{
    Region region;
    if (!largest_ki_per_s(motor, inside_kp)) {
        return region;
    }
    const double first = last_kp(motor, inside_kp, -1);
    const double last = last_kp(motor, inside_kp, 1);
    for (int k = 0; k < points; k++) {
        const double kp = first + (last - first) * k / (points - 1);
        region.kp.push_back(kp);
        region.ki_per_s.push_back(largest_ki_per_s(motor, kp).value_or(0));
    }
    return region;
}

} // namespace nf::design
