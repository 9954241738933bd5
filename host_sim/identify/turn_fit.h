/* SPDX-License-Identifier: MIT */
// Flux linkage, inertia and friction of the records of a rotor that turns.
#pragma once

#include "inductance_fit.h"

namespace nf::identify
{

struct FluxAtSpeed {
    double speed_el_rad_s = 0;
    Value wb;
};

struct Flux {
    Value wb; // of both ways
    // Of turning at two currents, without what L makes of it.
    Value turning_wb;
    Value coasting_wb;         // of the EMF without current
    bool has_coasted = true;   // some coasting windows agree with each other
    double speed_el_rad_s = 0; // highest
    // At the whole current, with what L makes of it, from the lowest speed on.
    std::vector<FluxAtSpeed> over_speed;

    // What the two ways lie apart beyond both bars, 0 or more.
    double disagreement_wb() const;
    // Coasting is a part of `wb`: it does not disagree by a tenth.
    bool coasting_counts() const;
};

// v = R·i + legs + jωL·i + jωφ·e^(−jδ). The L that the whole and half of the current agree upon is
// used. Throws ConfigError where the rotor was not turned.
Flux fit_flux(const Records &records, const Legs &legs, const Inductances &inductances);

// The EMF of a window over jω, Wb: it lies where the rotor is in the frame of the current.
std::complex<double> rotor_wb(const Record &turning, const Legs &legs,
                              const Inductances &inductances);

// J by the impulse of ramps up and down, friction by the speed of coasting and by the torque at
// constant speed.
struct Shaft {
    Value inertia_kg_m2;
    // Ramps of another steepness have another J, or the torque after them or at one speed is not
    // that of friction.
    bool swings = false;
    double swing_kg_m2 = 0; // what a load that swings may add or take; a bound of J where it does
    Value viscous_nm_s;
    Value coulomb_nm;
};

// Throws ConfigError where there are no ramps.
Shaft fit_shaft(const Records &sent, const Legs &legs, const Flux &flux);

} // namespace nf::identify
