/* SPDX-License-Identifier: MIT */
// What of a signal is forced, by the rotor's own turning or by the supply. An offset of a current
// sensor shows once in an electrical turn, gains that differ twice, dead time, cogging and a
// back-EMF that is no sine six or twelve times; a rectified supply has its own ripple. Each goes
// with an angle and has no memory; a limit cycle has a frequency of its own. A load that goes with
// the turn is not looked for.
#pragma once

#include "ripple_fit.h"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace nf
{

// Signals at a command, a load and a supply that do not change, and what is left of each without
// that ripple.
//
// How large a ripple is depends on the speed. The drive may have to give way meanwhile, rest, and
// accelerate again: one fit to all of that would find ripple in the change of speed, and leave it
// as a swing. So the signals are cut into steady stretches, in which the mean speed of an
// electrical turn stays within a band of 10 %. Each has a fit of its own, by least squares,
// together with a parabola; the turns in which the speed begins and ends to change are not fitted.
// A fit needs two electrical turns that have settled: neighbouring orders then differ by two
// periods. A stretch without one takes the nearest fit. Where no stretch has two turns there is one
// fit to all that has settled, and with less than two turns in all nothing is taken off. A swing of
// its own that lies within one period in all turns of an order counts as ripple: with two turns
// that is half an order, with more turns less.
class Ripple
{
public:
    static constexpr std::size_t SIGNALS = RippleFit::SIGNALS;
    using Values = RippleFit::Values; // of one tick, each in a unit of its own

    // The angle is the rotor's, electrical; the other one is that of the supply's ripple, 0 where
    // it has none.
    void add(double angle_el_rad, const Values &values, double supply_rad = 0);
    void clear();

    struct Split {
        std::vector<double> signal; // tick by tick
        std::vector<double> rest;   // of it, without ripple
        std::optional<double>
            amplitude; // of the rotor's ripple: half of its height, the largest fit
    };
    // The part from this tick on has settled.
    std::array<Split, SIGNALS> split(std::size_t settled) const;

private:
    // Samples from `from` to before `to`.
    struct Stretch {
        std::size_t from;
        std::size_t to;
    };
    struct Fitted {
        Stretch of;
        RippleFit fit;
    };

    double turned_rad(const Stretch &stretch) const;
    std::size_t turn_end(std::size_t from) const;
    std::size_t turn_begin(std::size_t to) const;
    Stretch inside(const Stretch &stretch, std::size_t settled) const;
    std::vector<Stretch> steady_stretches() const;
    std::vector<Fitted> fits(std::size_t settled) const;
    std::optional<Fitted> fitted(const Stretch &part) const;
    void take_off(const RippleFit &fit, const Stretch &stretch,
                  std::array<Split, SIGNALS> &splits) const;

    std::vector<RippleFit::Sample> samples_;
};

} // namespace nf
