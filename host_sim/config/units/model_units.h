/* SPDX-License-Identifier: MIT */
// The firmware's numbers of how far the model is corrected, and how fast.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

// How far the model may be corrected, as the largest factor on a weight of the observer or a gain.
struct ModelHeadroom {
    double weight;     // T·R/L, T/L
    double rate;       // (L/φ)²
    double flux;       // φ/L
    double saliency;   // L_q/L_d
    double inductance; // L_q
};
ModelHeadroom model_headroom(const TuningSettings &tuning);

model_cfg_t make_model_cfg(const MotorSettings &motor, const TuningSettings &tuning, const Model &m,
                           const Bases &b);

} // namespace nf
