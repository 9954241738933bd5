/* SPDX-License-Identifier: MIT */
// L_d and L_q of the pulses at rest.
#pragma once

#include "legs_fit.h"

namespace nf::identify
{

struct Inductances {
    Value d_h;            // without current
    Value q_h;            // flux over current at current_a, without i_d
    double current_a = 0; // of the pulses across, for which L_q is stated
    double quarter_s = 0; // duration of their quarter
};

// Each burst gives the L with which a model of the winding, its resistance and its legs answers as was measured. 1/L_d is
// a parabola over the bias, 1/L_q a polynomial of the pulse's current, as iron saturates. The sensors' mismatch cancels in
// the mean of the three axes. current_a: for which L_q is stated, at most that of the pulses. Throws ConfigError where there
// are too few bursts.
Inductances fit_inductances(const Records &records, const Legs &legs, double current_a);

} // namespace nf::identify
