/* SPDX-License-Identifier: MIT */
// L_d and L_q of the pulses at rest.
#pragma once

#include "legs_fit.h"

#include <vector>

namespace nf::identify
{

// An inductance and the current to which it belongs.
struct AtCurrent {
    double current_a = 0;
    Value h;
};

// Of the current sensors' low pass.
struct SensorLag {
    Value s; // time constant; 0: none shows
    // The longest one that chance may hide: what slow and fast pulses show, and a standard
    // deviation more.
    double hidden_s = 0;
};

// L along the axis of each phase over that of all three, less one, with the gains of
// Legs::mismatch.
struct AxisShares {
    double share[3] = {0, 0, 0};
    double std = 0; // of each, at most
};

struct Inductances {
    Value d_h; // without current
    Value q_h; // flux over current at current_a, without i_d
    // The curves through all bursts, at the currents of the bursts. L_d: for small changes of a
    // current along. L_q: flux over current across.
    std::vector<AtCurrent> d_over_current;
    std::vector<AtCurrent> q_over_current;
    double current_a = 0; // of the pulses across, for which L_q is stated
    SensorLag lag;
    // 1.5·P²·φ²/J of the rotor alone, where it turns further under the pulses than with the inertia
    // that is known; 0: it does not
    double alone_h_s2 = 0;
    AxisShares axes;
};

// What is known of the rotor that the pulses across turn a little.
struct Turned {
    double rotor_h_s2 = 0;    // 1.5·P²·φ²/J; 0: nothing
    bool load_swings = false; // the ramps show it: the pulses turn less than that J
};

// Each burst gives the L with which a model of the winding, its resistance and its legs answers as
// was measured. 1/L_d is a parabola over the bias, 1/L_q a polynomial of the pulse's current, as
// iron saturates. The sensors' mismatch cancels in the mean of the three axes.
// current_a: for which L_q is stated, at most that of the pulses. Throws ConfigError where there
// are too few bursts.
Inductances fit_inductances(const Records &records, const Legs &legs, double current_a,
                            const Turned &turned = {});

} // namespace nf::identify
