/* SPDX-License-Identifier: MIT */
// What a burst of pulses should do to the current, edge by edge of the inverter's legs.
#pragma once

#include "legs_fit.h"

namespace nf::identify
{

// The sum of the current's changes along the pulses, each with its pulse's sign, A, of a winding with this inductance,
// above 0. The rotor rests.
double modelled_change(const Record &burst, const Legs &legs, double inductance_h);

} // namespace nf::identify
