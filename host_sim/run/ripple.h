/* SPDX-License-Identifier: MIT */
// What of a signal the rotor's own turning forces: gains of the sensors that differ show twice in an electrical turn, dead
// time, cogging and a back-EMF that is no sine six or twelve times. It goes with the angle and has no memory; a limit
// cycle has a frequency of its own. An offset of a sensor, the bus and a load that goes with the turn are not looked for.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace nf
{

// The signal at conditions that do not change, and what is left of it without that ripple. The ripple is fitted by least
// squares to the settled part, beside a parabola. Two electrical turns are asked for, which hold two periods more of one order
// than of the next: less tells nothing apart, and all is left. A swing of its own within half an order of 2, 6 or 12 is
// taken for ripple then, and within 1/(turns) of them in general.
class Ripple
{
public:
    // The rotor's electrical angle, and any unit.
    void add(double angle_el_rad, double value);
    void clear();

    struct Split {
        std::vector<double> rest;
        std::optional<double> amplitude; // of the ripple: half of its height, where it was fitted
    };
    // The part from this sample on has settled.
    Split split(std::size_t settled) const;

private:
    struct Sample {
        double angle_el_rad;
        double value;
    };
    double turned_rad(std::size_t from) const;

    std::vector<Sample> samples_;
};

} // namespace nf
