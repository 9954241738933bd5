/* SPDX-License-Identifier: MIT */
// What of a signal the rotor's own turning forces: gains of the sensors that differ show twice in an electrical turn, dead
// time, cogging and a back-EMF that is no sine six or twelve times. It goes with the angle and has no memory; a limit
// cycle has a frequency of its own. An offset of a sensor, the bus and a load that goes with the turn are not looked for.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace nf
{

// Signals at conditions that do not change, and what is left of each without that ripple. The ripple is fitted to the settled part by
// least squares, together with a parabola. The fit needs two electrical turns: neighbouring orders then differ by two periods. With
// less nothing is taken off. A swing of its own that lies within one period in all turns of order 2, 6 or 12 counts as ripple: with
// two turns that is half an order, with more turns less.
class Ripple
{
public:
    static constexpr std::size_t SIGNALS = 2;
    using Values = std::array<double, SIGNALS>; // of one tick, each in a unit of its own

    // The angle is the rotor's, electrical.
    void add(double angle_el_rad, const Values &values);
    void clear();

    struct Split {
        std::vector<double> rest;        // tick by tick
        std::optional<double> amplitude; // of the ripple: half of its height, where it was fitted
    };
    // The part from this tick on has settled.
    std::array<Split, SIGNALS> split(std::size_t settled) const;

private:
    struct Sample {
        double angle_el_rad;
        Values values;
    };
    double turned_rad(std::size_t from) const;

    std::vector<Sample> samples_;
};

} // namespace nf
