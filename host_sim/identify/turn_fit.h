/* SPDX-License-Identifier: MIT */
// Flux linkage, inertia and friction of the records of a rotor that turns.
#pragma once

#include "inductance_fit.h"

namespace nf::identify
{

struct Flux {
    Value wb; // of both ways
    Value
        turning_wb; // of turning at a whole and at half of the current, without what L makes of it
    Value coasting_wb;         // of the EMF without current
    bool has_coasted = true;   // some coasting can be used
    double speed_el_rad_s = 0; // highest
};

// v = R·i + legs + jωL·i + jωφ·e^(−jδ). The L that the whole and half of the current agree upon is used. Throws ConfigError
// where the rotor was not turned.
Flux fit_flux(const Records &records, const Legs &legs, const Inductances &inductances);

// J by the impulse of ramps up and down, friction by the speed of coasting and by the torque at constant speed.
struct Shaft {
    Value inertia_kg_m2;
    Value viscous_nm_s;
    Value coulomb_nm;
};

// Throws ConfigError where there are no ramps.
Shaft fit_shaft(const Records &records, const Flux &flux);

} // namespace nf::identify
