/* SPDX-License-Identifier: MIT */
// Inductances of both axes, from bursts of voltage pulses (burst.h).
//
//   d   the pulses are small against the current they ride on: 1/L_d is that of a small change, linear in the current,
//       1/L_d = a + b·i. Stated without current, 1/a.
//   q   the pulses go from no current to A and back: L_q is flux over current, λ/A, and 1/L_q = a + b·λ² + c·i_d. Stated
//       for i_d = 0 and the continuous current, where λ·(a + b·λ²) is that current.
#pragma once

#include "burst.h"

namespace nf::identify
{

struct Inductances {
    Estimate d_h;
    Estimate q_h;
    double per_d = 0;        // a of the d axis, 1/H
    double bend_d = 0;       // b, 1/(H·A)
    double fall_q = 0;       // of L_q by the continuous current, as a share
    double continuous_a = 0; // where L_q is stated
    int quarter_q = 0;       // ticks of the longest pulses across

    // Flux linkage of a current along d, Wb.
    double flux_d(double current_a) const;
};

// `rotor` has the φ and acceleration of a rotor that the pulses move; its inductances are not read. Throws
// std::runtime_error where there are fewer than three bursts of either kind.
Inductances fit_inductances(const std::vector<Burst> &bursts, const Legs &legs, const Moved &rotor);

} // namespace nf::identify
