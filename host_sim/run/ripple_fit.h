/* SPDX-License-Identifier: MIT */
// The least squares fit of what goes with the rotor's angle, and with that of the supply's ripple,
// in two signals (ripple.h).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace nf
{

class RippleFit
{
public:
    static constexpr std::size_t SIGNALS = 2;
    using Values = std::array<double, SIGNALS>;

    struct Sample {
        double angle_el_rad;
        Values values;
        double supply_rad;
    };

    // Of the samples from `from` to before `to`, in which the rotor makes `turned_rad`, a
    // magnitude.
    RippleFit(const std::vector<Sample> &samples, std::size_t from, std::size_t to,
              double turned_rad);

    // What goes with both angles in any sample.
    Values forced(const Sample &sample) const;
    // Half of the height of what goes with the rotor's angle, over the samples of the fit.
    const Values &amplitude() const
    {
        return amplitude_;
    }

private:
    static constexpr std::size_t ORDERS = 4;
    static constexpr std::size_t SETTLING = 3; // terms of the parabola
    static constexpr std::size_t SUPPLY = SETTLING + 2 * ORDERS;
    static constexpr std::size_t TERMS = SUPPLY + 2;
    using Terms = std::array<double, TERMS>;
    using Fits = std::array<Terms, SIGNALS>;
    struct NormalEquations;

    Terms terms(double place, const Sample &sample) const;
    Values sum(const Terms &terms, std::size_t end) const;
    static Fits solved(NormalEquations equations);

    double highest_; // order that shows
    Fits found_;
    Values amplitude_{};
};

} // namespace nf
