// SPDX-License-Identifier: MIT
#include "ripple.h"

extern "C" {
#include "rotation.h"
}

#include <Eigen/Dense>

#include <cmath>

namespace nf
{
namespace
{

constexpr double HALF_TURN = 3.14159265358979323846;
constexpr double LEAST_TURNS = 2;
constexpr std::array<double, 3> ORDERS = {2, 6, 12};
constexpr int SETTLING = 3; // terms of the parabola
constexpr int TERMS = SETTLING + 2 * static_cast<int>(ORDERS.size());

using Terms = Eigen::Matrix<double, TERMS, 1>;
using Square = Eigen::Matrix<double, TERMS, TERMS>;
// A column for each signal.
using Fits = Eigen::Matrix<double, TERMS, Ripple::SIGNALS>;
using Row = Eigen::Matrix<double, 1, Ripple::SIGNALS>;

// An order that makes half a turn or more from tick to tick looks like a lower one, and is left out.
struct Basis {
    double ticks;   // of the signal
    double highest; // order

    Terms at(std::size_t tick, double angle_el_rad) const
    {
        const double place = static_cast<double>(tick) / ticks;
        Terms terms = Terms::Zero();
        terms.head<SETTLING>() << 1, place, place * place;
        int k = SETTLING;
        for (const double order : ORDERS) {
            const bool shows = order < highest;
            const plant_rotation_t turned = plant_rotation_from_angle(order * angle_el_rad);
            terms[k++] = shows ? turned.cosine : 0;
            terms[k++] = shows ? turned.sine : 0;
        }
        return terms;
    }
};

} // namespace

void Ripple::add(double angle_el_rad, const Values &values)
{
    samples_.push_back({angle_el_rad, values});
}

void Ripple::clear()
{
    samples_.clear();
}

double Ripple::turned_rad(std::size_t from) const
{
    double turned = 0;
    for (std::size_t k = from + 1; k < samples_.size(); k++) {
        turned +=
            std::remainder(samples_[k].angle_el_rad - samples_[k - 1].angle_el_rad, 2 * HALF_TURN);
    }
    return std::abs(turned);
}

std::array<Ripple::Split, Ripple::SIGNALS> Ripple::split(std::size_t settled) const
{
    std::array<Split, SIGNALS> splits;
    for (std::size_t n = 0; n < SIGNALS; n++) {
        for (const Sample &sample : samples_) {
            splits[n].rest.push_back(sample.values[n]);
        }
    }
    const double turned = turned_rad(settled);
    if (turned < LEAST_TURNS * 2 * HALF_TURN) {
        return splits;
    }
    const Basis basis = {static_cast<double>(samples_.size()),
                         HALF_TURN * static_cast<double>(samples_.size() - settled) / turned};
    Square products = Square::Zero();
    Fits sums = Fits::Zero();
    for (std::size_t k = settled; k < samples_.size(); k++) {
        const Terms terms = basis.at(k, samples_[k].angle_el_rad);
        products.noalias() += terms * terms.transpose();
        sums.noalias() += terms * Eigen::Map<const Row>(samples_[k].values.data());
    }
    // The smallest of all solutions: an order that does not show gets nothing.
    Fits found = products.completeOrthogonalDecomposition().solve(sums);
    found.topRows<SETTLING>().setZero();
    Row low = Row::Zero();
    Row high = Row::Zero();
    for (std::size_t k = 0; k < samples_.size(); k++) {
        const Row forced = basis.at(k, samples_[k].angle_el_rad).transpose() * found;
        low = low.cwiseMin(forced);
        high = high.cwiseMax(forced);
        for (std::size_t n = 0; n < SIGNALS; n++) {
            splits[n].rest[k] -= forced[static_cast<Eigen::Index>(n)];
        }
    }
    for (std::size_t n = 0; n < SIGNALS; n++) {
        const auto column = static_cast<Eigen::Index>(n);
        splits[n].amplitude = (high[column] - low[column]) / 2;
    }
    return splits;
}

} // namespace nf
