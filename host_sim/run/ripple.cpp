// SPDX-License-Identifier: MIT
#include "ripple.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
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

// An order that turns by half a turn in a sample looks like a lower one.
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
            terms[k++] = shows ? std::cos(order * angle_el_rad) : 0;
            terms[k++] = shows ? std::sin(order * angle_el_rad) : 0;
        }
        return terms;
    }
};

} // namespace

void Ripple::add(double angle_el_rad, double value)
{
    samples_.push_back({angle_el_rad, value});
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

Ripple::Split Ripple::split(std::size_t settled) const
{
    Split split;
    for (const Sample &sample : samples_) {
        split.rest.push_back(sample.value);
    }
    const double turned = turned_rad(settled);
    if (turned < LEAST_TURNS * 2 * HALF_TURN) {
        return split;
    }
    const Basis basis = {static_cast<double>(samples_.size()),
                         HALF_TURN * static_cast<double>(samples_.size() - settled) / turned};
    Square products = Square::Zero();
    Terms sums = Terms::Zero();
    for (std::size_t k = settled; k < samples_.size(); k++) {
        const Terms terms = basis.at(k, samples_[k].angle_el_rad);
        products.noalias() += terms * terms.transpose();
        sums += terms * samples_[k].value;
    }
    // The least of all solutions: an order that does not show has none.
    Terms found = products.completeOrthogonalDecomposition().solve(sums);
    found.head<SETTLING>().setZero();
    double low = 0;
    double high = 0;
    for (std::size_t k = 0; k < samples_.size(); k++) {
        const double forced = found.dot(basis.at(k, samples_[k].angle_el_rad));
        low = std::min(low, forced);
        high = std::max(high, forced);
        split.rest[k] -= forced;
    }
    split.amplitude = (high - low) / 2;
    return split;
}

} // namespace nf
