/* SPDX-License-Identifier: MIT */
// What an identification of a simulated motor should find.
#pragma once

#include "config.h"

extern "C" {
#include "iron.h"
}

#include <array>

namespace nf::identify
{

struct Truth {
    double resistance_ohm = 0;
    double inductance_d_h = 0; // without current
    double inductance_q_h = 0; // flux over current at the continuous current, without i_d
    double flux_linkage_wb = 0;
    double inertia_kg_m2 = 0;
    double viscous_friction_nm_s = 0;
    double coulomb_friction_nm = 0;
    double dead_time_s = 0; // with the device drop as dead time
    double knee_a = 0;      // 0: legs commutate at once
    double current_a = 0;   // the continuous one
    double gain_mismatch_pct = 0;
    double current_noise_lsb = 0; // rms, of a count too
    plant_iron_cfg_t iron{};
    // Where each pattern of the Hall signals begins, the pattern as index; NAN: nowhere.
    std::array<double, 8> halls_deg{};
};

// Of the machine of a configuration: its motor times the scales of [plant], its board, saturated
// iron. Throws ConfigError as make_plant_cfg() does.
Truth truth_of(const Config &config);

// L_d for small changes of a current along, without i_q.
double inductance_d_h(const Truth &truth, double current_a);

// L_q, flux over current across, without i_d. current_a: above 0.
double inductance_q_h(const Truth &truth, double current_a);

// What a leg with this dead time and knee loses against a current, as a time, s: the whole dead
// time far beyond the knee.
double lost_time_s(double dead_time_s, double knee_a, double current_a);

} // namespace nf::identify
