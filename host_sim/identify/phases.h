/* SPDX-License-Identifier: MIT */
// Whether the three phases of a motor are alike, and what of their difference is one of the current
// sensors.
#pragma once

#include "inductance_fit.h"

namespace nf::identify
{

struct Phases {
    Value mismatch; // gain of sensor a over that of sensor b, less one
    bool are_unlike = false;
    int phase = 0; // the one that differs most: 0, 1, 2
    // What it has over the mean of the other two, less one.
    double resistance_share = 0;
    double inductance_share = 0; // 0: too little to be told
};

// Along the axis of a phase R and L are the mean of the phase and of all three. The gain of a
// sensor changes R and L of its axis alike, a contact R only, and a winding of fewer turns R by as
// many and L by twice as many.
Phases fit_phases(const Legs &legs, const Inductances &inductances);

} // namespace nf::identify
