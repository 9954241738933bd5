/* SPDX-License-Identifier: MIT */
// A burst of voltage pulses on a rotor at rest, and what current a motor of known values answers with.
//
// The voltage is what holds the current i_0 along the d axis, which stands along a phase, and on top of it +V, −V, −V, +V for
// so many ticks each, along or across. With u the loss of the legs and ω the speed that the torque gives to the rotor:
//
//   L_d·di_d/dt = V_d + R·i_0 + u_d(i_0) − R·i_d − u_d(i)
//   L_q·di_q/dt = V_q                    − R·i_q − u_q(i) − ω·(φ + L_d·i_d)
//   dω/dt       = 1.5·P²/J·(φ + (L_d − L_q)·i_d)·i_q
#pragma once

#include "legs.h"

namespace nf::identify
{

struct Burst {
    bool along = true;
    int axis = 0;
    double held_a = 0;   // i_0
    double mean_a = 0;   // of i_d in the window
    double pulse_v = 0;  // V
    int quarter = 1;     // ticks
    int ticks = 1;       // of the window
    double change_a = 0; // sum of the current's changes, each with the sign of its pulse
    double period_s = 0;
    double bus_v = 0;

    // The current at the end of the first quarter, mean of all.
    double peak_a() const;
};

// What the pulses move. A rotor that stands still has no φ.
struct Moved {
    double inductance_d_h = 0;
    double inductance_q_h = 0;
    double flux_wb = 0;
    double acceleration = 0; // 1.5·P²/J; 0: it stands still
};

// The windows of kind "burst", their currents with the mismatch of the sensors taken out.
std::vector<Burst> bursts_of(const Records &records, const Legs &legs);

// Burst::change_a of that motor.
double answer(const Burst &burst, const LegModel &legs, const Moved &motor);

// The inductance along the pulses, constant, of a motor that answers as measured; `motor` says the rest of it and where
// the search begins. Throws std::runtime_error where no inductance gives that answer.
double inductance_of(const Burst &burst, const LegModel &legs, const Moved &motor);

} // namespace nf::identify
