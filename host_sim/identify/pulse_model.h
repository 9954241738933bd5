/* SPDX-License-Identifier: MIT */
// What a burst of pulses should do to the current, edge by edge of the inverter's legs.
#pragma once

#include "legs_fit.h"

namespace nf::identify
{

// The sum of the current's changes along the pulses, each with its pulse's sign, A, of a winding
// with this inductance, above 0, as sensors behind a low pass of this time constant see it. The
// rotor rests.
double modelled_change(const Record &burst, const Legs &legs, double inductance_h,
                       double sensor_lag_s = 0);

// The records with the currents that sensors without a low pass would have shown. Of a current at
// rest that is what flows between the edges of its voltage while the converter samples; a vector
// that turns is seen smaller and later.
Records without_lag(const Records &records, const Legs &legs, double inductance_h,
                    double sensor_lag_s);

} // namespace nf::identify
