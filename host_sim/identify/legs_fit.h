/* SPDX-License-Identifier: MIT */
// Resistance, and what the legs of the inverter lose against their current, of the voltages at
// rest.
#pragma once

#include "records.h"

#include <complex>

namespace nf::identify
{

// A value with its standard deviation, from the scatter of the measurement, and a bound on what
// repeats itself.
struct Value {
    double value = 0;
    double std = 0;
    double bound = 0;
};

// The share of the loss at a large current that a leg loses at z knees, knee.h; of the current's
// sign.
double lost_share(double z);

struct Legs {
    Value resistance_ohm; // at the beginning
    // Of a leg for a large current: dead time over period times bus, and the device drop.
    Value loss_v;
    Value knee_a;   // half of that is lost there (host_sim/plant/knee.h)
    Value mismatch; // gain of sensor a less that of sensor b, of their mean; phases of unlike R are
                    // in it
    Value third;    // R on the axis of phase c over that of all three axes, less one
    Value warming;  // the share by which the winding's R has risen at the end of the levels
    double bus_v = 0; // mean
    double period_s = 0;
    double largest_a = 0; // of the levels

    // With another bus voltage: the dead time takes its share of it.
    Legs at_bus(double volts) const;
    // Voltage that a leg loses at a current.
    double lost_v(double leg_a) const;
    // The mean loss along a current vector that turns, |i| its length.
    double lost_turning_v(double current_a) const;
    // Loss of the vector with these components in the frame of a phase's axis: along and across.
    std::complex<double> lost_v(std::complex<double> current) const;
    // R at the end of the levels, when the rotor begins to turn.
    double warm_ohm() const
    {
        return resistance_ohm.value * (1 + warming.value);
    }
    // The share of a current that R takes in a period.
    double decay(double inductance_h) const
    {
        return resistance_ohm.value * period_s / inductance_h;
    }
    double dead_time_s() const
    {
        return loss_v.value * period_s / bus_v;
    }
};

// The curve v = R·i + 2/3·(f(i) + f(i/2)) through all levels on the three axes, f as knee.h has it;
// with the gains of the sensors 1 + m/2 and 1 − m/2, as their mean cannot be seen. f follows the
// bus, which sags under a current. R is the mean of the three axes; phases.h tells what they differ
// by. The winding takes up i²·t and gets warm: R·(1 + w·h), h from 0 to 1 as the sum of i²·t grows.
// The levels go down and up again, so w shows; R is that of the beginning. A rise below 1 % is not
// told from what differs between the axes: R is that of all levels then, and half of the rise is in
// its bound. Throws ConfigError where there are too few levels.
Legs fit_legs(const Records &records);

// Adds to the bounds what the ripple of the current makes of R and of the loss, for which L has to
// be known: the legs lose against the current at their edges, not against its mean.
void add_ripple_bounds(Legs &legs, double inductance_h);

// Adds to the bounds what a converter does that shifts each measured current by up to shift_a when
// it rounds: the same voltage is missing at each level.
void add_rounding_bounds(Legs &legs, double shift_a);

// Adds to the bounds what currents do that are measured with so large an error, a share of the
// largest one: R takes all of it, or the loss half.
void add_unsure_current(Legs &legs, double share);

} // namespace nf::identify
