/* SPDX-License-Identifier: MIT */
// Windows in which the vector turns: what is left of the voltage is the rotor's EMF.
//
//   e = v·sinc(ωT/2) − R·i − u(|i|)·i/|i|          u: mean loss of the legs along a current that turns
//
// A voltage held for a tick while the frame turns by ωT is shorter by sinc(ωT/2) in the rotor's frame.
#pragma once

#include "inductance_fit.h"

namespace nf::identify
{

// e, mean of the window.
std::complex<double> emf_of(const Window &window, const LegModel &legs, double period_s);

// Flux linkage of the magnet, Wb: |e − jω·L_q·i| = ω·(φ + flux of i_d less L_q·i_d), with i_d of a rotor that lags by the angle
// of that vector. The speed is not 0.
double magnet_of(const Window &window, const LegModel &legs, const Inductances &inductances,
                 double period_s);

// Mechanical torque of the EMF, N·m: 1.5·P·Re(e·conj(i))/ω. The speed is not 0.
double torque_of(const Window &window, const LegModel &legs, const Scales &scales);

} // namespace nf::identify
