// SPDX-License-Identifier: MIT
#include "ripple_fit.h"

extern "C" {
#include "rotation.h"
}

#include <algorithm>
#include <iterator>

namespace nf
{
namespace
{

constexpr double HALF_TURN = 3.14159265358979323846;
constexpr double NUMBERS[] = {1, 2, 6, 12}; // of the orders

constexpr double NEGLIGIBLE = 1e-12; // of a square, where the sums have 16 digits

} // namespace

// The normal equations of a least squares fit. Sums one after the other: a library that adds
// several at once has other last digits on another processor.
struct RippleFit::NormalEquations {
    std::array<Terms, TERMS> products{}; // row by row, up to the diagonal
    Fits sums{};

    void add(const Terms &terms, const Values &values)
    {
        for (std::size_t row = 0; row < TERMS; row++) {
            for (std::size_t column = 0; column <= row; column++) {
                products[row][column] += terms[row] * terms[column];
            }
            for (std::size_t n = 0; n < SIGNALS; n++) {
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
RippleFit::Fits RippleFit::solved(NormalEquations equations)
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
    for (std::size_t n = 0; n < SIGNALS; n++) {
        found[n] = equations.back_substituted(equations.sums[n], counts);
    }
    return found;
}

// An order that makes half a turn or more from tick to tick looks like a lower one, and is left
// out. Of a supply without ripple there is a constant, which the parabola has already.
RippleFit::Terms RippleFit::terms(double place, const Sample &sample) const
{
    Terms terms = {1, place, place * place};
    std::size_t k = SETTLING;
    for (const double order : NUMBERS) {
        const bool shows = order < highest_;
        const plant_rotation_t turned = plant_rotation_from_angle(order * sample.angle_el_rad);
        terms[k++] = shows ? turned.cosine : 0;
        terms[k++] = shows ? turned.sine : 0;
    }
    const plant_rotation_t supply = plant_rotation_from_angle(sample.supply_rad);
    terms[SUPPLY] = supply.cosine;
    terms[SUPPLY + 1] = supply.sine;
    return terms;
}

RippleFit::RippleFit(const std::vector<Sample> &samples, std::size_t from, std::size_t to,
                     double turned_rad)
    : highest_(HALF_TURN * static_cast<double>(to - from) / turned_rad)
{
    static_assert(std::size(NUMBERS) == ORDERS);
    NormalEquations equations;
    for (std::size_t k = from; k < to; k++) {
        const double place = static_cast<double>(k - from) / static_cast<double>(to - from);
        equations.add(terms(place, samples[k]), samples[k].values);
    }
    found_ = solved(equations);
    Values low{};
    Values high{};
    for (std::size_t k = from; k < to; k++) {
        const Values now = sum(terms(0, samples[k]), SUPPLY);
        for (std::size_t n = 0; n < SIGNALS; n++) {
            low[n] = std::min(low[n], now[n]);
            high[n] = std::max(high[n], now[n]);
        }
    }
    for (std::size_t n = 0; n < SIGNALS; n++) {
        amplitude_[n] = (high[n] - low[n]) / 2;
    }
}

// Of the terms behind the parabola, up to `end`.
RippleFit::Values RippleFit::sum(const Terms &terms, std::size_t end) const
{
    Values values{};
    for (std::size_t n = 0; n < SIGNALS; n++) {
        for (std::size_t term = SETTLING; term < end; term++) {
            values[n] += terms[term] * found_[n][term];
        }
    }
    return values;
}

RippleFit::Values RippleFit::forced(const Sample &sample) const
{
    return sum(terms(0, sample), TERMS);
}

} // namespace nf
