/* SPDX-License-Identifier: MIT */
// Resistance, and what the legs of the inverter lose against their current, of the voltages at rest.
#pragma once

#include "records.h"

#include <complex>

namespace nf::identify
{

// A value with its standard deviation, from the scatter of the measurement, and a bound on what repeats itself.
struct Value {
    double value = 0;
    double std = 0;
    double bound = 0;
};

// The share of the loss at a large current that a leg loses at z knees, knee.h; of the current's sign.
double lost_share(double z);

struct Legs {
    Value resistance_ohm;
    Value
        loss_v; // of a leg for a large current: dead time over period times bus, and the device drop
    Value knee_a;     // half of that is lost there (host_sim/plant/knee.h)
    Value mismatch;   // gain of sensor a over that of sensor b, less one
    double bus_v = 0; // mean
    double period_s = 0;

    // Voltage that a leg loses at a current.
    double lost_v(double leg_a) const;
    // The mean loss along a current vector that turns, |i| its length.
    double lost_turning_v(double current_a) const;
    // Loss of the vector with these components in the frame of a phase's axis: along and across.
    std::complex<double> lost_v(std::complex<double> current) const;
    double dead_time_s() const
    {
        return loss_v.value * period_s / bus_v;
    }
};

// The curve v = R·i + 2/3·(f(i) + f(i/2)) through all levels on the three axes, f as knee.h has it; with the gains of the
// sensors 1 + m/2 and 1 − m/2, as their mean cannot be seen. The winding's warming shows as a slope over the order of the
// levels; it is taken off, R is that of the beginning. Throws ConfigError where there are too few levels.
Legs fit_legs(const Records &records);

} // namespace nf::identify
