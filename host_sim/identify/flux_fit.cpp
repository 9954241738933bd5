// SPDX-License-Identifier: MIT
#include "flux_fit.h"

#include "least_squares.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>

namespace nf::identify
{
namespace
{

constexpr double FOLLOWED = 0.1;
constexpr double COASTS_SLIP = 0.005; // of |v|/ω: small currents flow, and the frame trembles
constexpr size_t COASTS_SKIPPED = 1; // the current still falls
constexpr size_t COASTS_MOST = 4;
constexpr double MODULATOR = 1.0 / 4096;
constexpr double SATURATES = 0.1; // of the flux of the current: how far L_d is not the same at half of it

double magnet_coasting(const Window &window, const LegModel &legs, double period_s)
{
    return std::abs(emf_of(window, legs, period_s) / window.speed_rad_s);
}

bool turns(const Window &window)
{
    return (window.kind == "spin" || window.kind == "hold") && window.command_rad_s != 0 &&
           window.command_a > 0 && window.speed_rad_s > 0;
}

// What volts that nobody knows count for in φ.
double voltage_error(const Window &window, const Legs &legs)
{
    const double along_v = legs.resistance_ohm.bar() * std::abs(window.current_a) +
                           4.0 / 3 * legs.loss_v.bar();
    return std::hypot(along_v / 4, MODULATOR * std::abs(window.voltage_v)) / window.speed_rad_s;
}

// φ and ε.
struct Equations {
    std::vector<Eigen::Vector3d> rows; // those of φ, ε, and the right side, each over its error

    void add(double flux, double epsilon, double right, double error)
    {
        rows.emplace_back(flux / error, epsilon / error, right / error);
    }

    Estimate solve() const
    {
        Eigen::MatrixXd a(static_cast<Eigen::Index>(rows.size()), 2);
        Eigen::VectorXd y(a.rows());
        for (Eigen::Index k = 0; k < a.rows(); k++) {
            a.row(k) = rows[static_cast<size_t>(k)].head<2>();
            y[k] = rows[static_cast<size_t>(k)][2];
        }
        const Fit fit = linear_least_squares(a, y);
        const Eigen::Matrix2d square = a.transpose() * a;
        return {fit.parameters[0], std::sqrt(square.inverse()(0, 0)), 0};
    }
};

// What the curve of the saturation leaves open between the whole and the half of the current.
double bent(const Inductances &inductances, double current_a)
{
    const double straight_wb = current_a / inductances.per_d;
    return std::abs(straight_wb - inductances.flux_d(current_a)) + SATURATES * 0.01 * straight_wb;
}

// Two estimates that agree, by the weight of their bars.
Estimate together(const Estimate &one, const Estimate &other)
{
    const double first = 1 / (one.bar() * one.bar());
    const double second = 1 / (other.bar() * other.bar());
    const double share = first / (first + second);
    return {share * one.value + (1 - share) * other.value,
            std::hypot(share * one.std, (1 - share) * other.std),
            share * one.bound + (1 - share) * other.bound};
}

Estimate coasting(const std::vector<Window> &windows, const Legs &legs, double period_s)
{
    std::vector<double> found;
    const size_t skipped = windows.size() > COASTS_SKIPPED ? COASTS_SKIPPED : 0;
    for (size_t k = skipped; k < std::min(windows.size(), skipped + COASTS_MOST); k++) {
        found.push_back(magnet_coasting(windows[k], legs.model, period_s));
    }
    std::sort(found.begin(), found.end());
    const double middle = found[found.size() / 2];
    const double spread = found.size() > 1 ? (found.back() - found.front()) / 2 : 0;
    return {middle, std::max(spread, voltage_error(windows[skipped], legs)),
            COASTS_SLIP * middle};
}

} // namespace

std::vector<Window> followed(const Records &records, const LegModel &legs, double flux_wb)
{
    std::vector<Window> found;
    for (const Window &window : records.of("coast")) {
        if (window.speed_rad_s <= 0 ||
            std::abs(magnet_coasting(window, legs, records.scales.period_s) / flux_wb - 1) >
                FOLLOWED) {
            break;
        }
        found.push_back(window);
    }
    return found;
}

bool agree(const Estimate &one, const Estimate &other)
{
    return std::abs(one.value - other.value) <= one.bar() + other.bar();
}

Flux fit_flux(const Records &records, const Legs &legs, const Inductances &inductances)
{
    Flux flux;
    Equations equations;
    const double alike = std::sqrt(static_cast<double>(
        std::count_if(records.windows.begin(), records.windows.end(), turns)));
    double most_a = 0;
    for (const Window &window : records.windows) {
        if (turns(window)) {
            const double magnet =
                magnet_of(window, legs.model, inductances, records.scales.period_s);
            // The errors of all windows are alike: many of them are no better than one.
            equations.add(1, std::abs(window.current_a), magnet,
                          alike * voltage_error(window, legs));
            flux.highest_rad_s = std::max(flux.highest_rad_s, window.speed_rad_s);
            most_a = std::max(most_a, std::abs(window.current_a));
        }
    }
    if (equations.rows.empty()) {
        throw std::runtime_error("no window turns: the flux linkage is not measured");
    }
    equations.add(0, 1, 0, inductances.d_h.bar() / 2);
    flux.turning_wb = equations.solve();
    flux.turning_wb.bound = bent(inductances, most_a);
    const std::vector<Window> windows = followed(records, legs.model, flux.turning_wb.value);
    if (!windows.empty()) {
        flux.coasting_wb = coasting(windows, legs, records.scales.period_s);
    }
    flux.magnet_wb = flux.turning_wb;
    if (flux.coasting_wb && agree(*flux.coasting_wb, flux.turning_wb)) {
        flux.magnet_wb = together(*flux.coasting_wb, flux.turning_wb);
    }
    return flux;
}

} // namespace nf::identify
