/* SPDX-License-Identifier: MIT */
// How far a real motor and its board are from their files, as users have them, and what disturbs
// the drive.
#pragma once

#include "specimen.h"

namespace nf::zoo
{

// Factors are real over file, shares of the rated torque.
struct Errors {
    double resistance_scale = 1;
    double inductance_scale = 1;
    double flux_scale = 1;
    double inertia_scale = 1;
    double saliency_scale = 1;
    double dead_time_scale = 1;
    double commutation_knee_a = 0;
    double coulomb_share = 0;
    double cogging_pct = 0;
    int cogging_order = 0;
    double emf_5th_pct = 0;
    double emf_7th_pct = 0;
    double adc_noise_lsb = 0;
    double adc_offset_lsb[2] = {0, 0};
    double adc_gain_error_pct[2] = {0, 0};
    double adc_third_gain_error_pct = 0;
    double bus_ripple_pct = 0;
    double bus_ripple_hz = 0;
    double load_share = 0; // from the start on
};

Errors draw_errors(const Draw &draw, const Specimen &specimen);

} // namespace nf::zoo
