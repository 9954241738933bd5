// SPDX-License-Identifier: MIT
#include "ripple.h"

extern "C" {
#include "rotation.h"
}

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double HALF_TURN = 3.14159265358979323846;
constexpr double LEAST_TURNS = 2;
constexpr std::array<double, 3> ORDERS = {2, 6, 12};
constexpr std::size_t SETTLING = 3; // terms of the parabola
constexpr std::size_t TERMS = SETTLING + 2 * ORDERS.size();

constexpr double NEGLIGIBLE = 1e-12; // of a square, where the sums have 16 digits

using Terms = std::array<double, TERMS>;
using Fits = std::array<Terms, Ripple::SIGNALS>;

// An order that makes half a turn or more from tick to tick looks like a lower one, and is left out.
struct Basis {
    double ticks;   // of the signal
    double highest; // order

    Terms at(std::size_t tick, double angle_el_rad) const
    {
        const double place = static_cast<double>(tick) / ticks;
        Terms terms = {1, place, place * place};
        std::size_t k = SETTLING;
        for (const double order : ORDERS) {
            const bool shows = order < highest;
            const plant_rotation_t turned = plant_rotation_from_angle(order * angle_el_rad);
            terms[k++] = shows ? turned.cosine : 0;
            terms[k++] = shows ? turned.sine : 0;
        }
        return terms;
    }
};

// The normal equations of a least squares fit. Sums one after the other: a library that adds several at once has other last
// digits on another processor.
struct NormalEquations {
    std::array<Terms, TERMS> products{}; // row by row, up to the diagonal
    Fits sums{};

    void add(const Terms &terms, const Ripple::Values &values)
    {
        for (std::size_t row = 0; row < TERMS; row++) {
            for (std::size_t column = 0; column <= row; column++) {
                products[row][column] += terms[row] * terms[column];
            }
            for (std::size_t n = 0; n < Ripple::SIGNALS; n++) {
                sums[n][row] += terms[row] * values[n];
            }
        }
    }

    // Takes a term out of all that come after it.
    void eliminate(std::size_t term)
    {
        for (std::size_t row = term + 1; row < TERMS; row++) {
            const double share = products[row][term] / products[term][term];
            for (std::size_t column = term + 1; column <= row; column++) {
                products[row][column] -= share * products[column][term];
            }
            for (Terms &sum : sums) {
                sum[row] -= share * sum[term];
            }
        }
    }

    // Of a signal, when each term that counts has been eliminated.
    Terms back_substituted(const Terms &sum, const std::array<bool, TERMS> &counts) const
    {
        Terms found{};
        for (std::size_t term = TERMS; term-- > 0;) {
            double left = sum[term];
            for (std::size_t row = term + 1; row < TERMS; row++) {
                left -= products[row][term] * found[row];
            }
            found[term] = counts[term] ? left / products[term][term] : 0;
        }
        return found;
    }
};

// An order that does not show, or that those before it make up, gets nothing.
Fits solved(NormalEquations equations)
{
    const auto squares = equations.products;
    std::array<bool, TERMS> counts{};
    for (std::size_t term = 0; term < TERMS; term++) {
        counts[term] = equations.products[term][term] > NEGLIGIBLE * squares[term][term];
        if (counts[term]) {
            equations.eliminate(term);
        }
    }
    Fits found{};
    for (std::size_t n = 0; n < Ripple::SIGNALS; n++) {
        found[n] = equations.back_substituted(equations.sums[n], counts);
    }
    return found;
}

// What goes with the angle.
double forced(const Terms &terms, const Terms &found)
{
    double sum = 0;
    for (std::size_t term = SETTLING; term < TERMS; term++) {
        sum += terms[term] * found[term];
    }
    return sum;
}

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
    NormalEquations equations;
    for (std::size_t k = settled; k < samples_.size(); k++) {
        equations.add(basis.at(k, samples_[k].angle_el_rad), samples_[k].values);
    }
    const Fits found = solved(equations);
    Values low{};
    Values high{};
    for (std::size_t k = 0; k < samples_.size(); k++) {
        const Terms terms = basis.at(k, samples_[k].angle_el_rad);
        for (std::size_t n = 0; n < SIGNALS; n++) {
            const double part = forced(terms, found[n]);
            low[n] = std::min(low[n], part);
            high[n] = std::max(high[n], part);
            splits[n].rest[k] -= part;
        }
    }
    for (std::size_t n = 0; n < SIGNALS; n++) {
        splits[n].amplitude = (high[n] - low[n]) / 2;
    }
    return splits;
}

} // namespace nf
