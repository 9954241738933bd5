/* SPDX-License-Identifier: MIT */
// Order and edges of three Hall signals, of records of a vector that turns backwards and forwards.
#pragma once

#include "turn_fit.h"

#include <array>
#include <string>

namespace nf::identify
{

// The angle at which a sector begins. Its pattern is there from this angle on, forwards.
struct HallEdge {
    int pattern = 0; // bit 0 is sensor 1
    Value deg;       // electrical
};

struct Halls {
    bool measured = false;
    std::string trouble;           // why they are not measured, in one line; empty where they are
    std::array<HallEdge, 6> edges; // in their order forwards, from the first one above 0° on
    // What the edges come late by in the direction of the turn, of the mean of all: hysteresis of
    // the sensors, and the time of their filters and of half a tick.
    double late_deg = 0;
    double speed_el_rad_s = 0; // at this speed
};

// A bar that is of use: a torque with an angle so wrong is 99 % of what it should be.
constexpr double HALL_BAR_MOST_DEG = 8;

// An edge is the mean of both directions, so what comes late in each of them cancels. The rotor
// lies where its EMF says it does. Total: what keeps the edges from being found is in `trouble`.
//
// The bar: from the scatter of the edges, which makes the vector of a signal shorter, and from the
// windows of one direction. The bound: half a tick as the edges of so many turns fall on the ticks;
// the part of the rotor's angle that is alike in both directions; cogging of 5 % of the rated
// torque, six times in an electrical turn.
Halls fit_halls(const Records &records, const Legs &legs, const Inductances &inductances,
                const Flux &flux, const Shaft &shaft);

} // namespace nf::identify
