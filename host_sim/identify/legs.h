/* SPDX-License-Identifier: MIT */
// Resistance of the winding and what the legs of the inverter lose, from levels of current at rest.
//
// A leg with current i loses V0·f(i/i_k) against it, f(z) = z/2 for |z| <= 1, sign(z)·(1 − 1/(2·|z|)) beyond
// (host_sim/plant/knee.h). With the current along a phase one leg carries i and the others −i/2:
//
//   v = R·i + 2/3·V0·(f(i/i_k) + f(i/(2·i_k)))
//
// The sensors of phases a and b have gains 1 + m and 1 − m: along a the true current is i/(1 + m), along b i/(1 − m), along
// c i. A gain that both share cannot be told from other volts.
#pragma once

#include "estimate.h"
#include "records.h"

#include <complex>

namespace nf::identify
{

struct LegModel {
    double resistance_ohm = 0; // of a phase
    double loss_v = 0;         // V0
    double knee_a = 1;         // i_k, above 0
};

struct Legs {
    LegModel model;
    Estimate resistance_ohm;
    Estimate loss_v;   // V0: dead time and device drop
    Estimate knee_a;
    Estimate mismatch; // m
    double heating = 0; // R at the end of the levels over R at their start, less one; 0 where it is within the noise
    double bus_v = 0;
    double largest_a = 0;
};

// f(z)
double knee_share(double z);

// What a leg with this current loses, V.
double leg_loss(const LegModel &legs, double current_a);

// The vector that the legs lose, V, at a current in a frame whose d axis stands along a phase.
std::complex<double> loss_at_rest(const LegModel &legs, std::complex<double> current_a);

// Its mean along a current of this amplitude that turns, V.
double loss_turning(const LegModel &legs, double current_a);

// What a measured current along or across the axis of a phase has to be divided by.
double gain_along(const Legs &legs, int axis);
double gain_across(const Legs &legs, int axis);

// From the windows of kind "still". Throws std::runtime_error where there are fewer than six or they do not differ.
Legs fit_legs(const Records &records);

} // namespace nf::identify
