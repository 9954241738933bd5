/* SPDX-License-Identifier: MIT */
// The firmware's numbers of what happens below the speed at which the back-EMF tells the angle: one rule
// for every motor, from its file.
#pragma once

#include "numbers.h"

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

startup_cfg_t make_startup(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                           const Bases &b);

// i_d* in RUN, with or without a start-up.
current_reference_cfg_t make_current_reference(const MotorSettings &motor,
                                               const BoardSettings &board,
                                               const TuningSettings &tuning,
                                               const ModelScales &scales, const Model &m,
                                               const Bases &b);

run_cfg_t make_run(const TuningSettings &tuning);

// Current control of an imposed current, given that of RUN.
current_loop_cfg_t make_hold_loop(const current_loop_cfg_t &run_loop, const MotorSettings &motor,
                                  const BoardSettings &board, const TuningSettings &tuning,
                                  const ModelScales &scales, const Model &m, const Bases &b);

// What supervision allows an imposed current; its other numbers stay.
void set_imposed_limits(supervision_cfg_t &c, const MotorSettings &motor,
                        const BoardSettings &board, const TuningSettings &tuning, const Model &m,
                        const Bases &b);

model_cfg_t make_model_cfg(const MotorSettings &motor, const TuningSettings &tuning, const Model &m,
                           const Bases &b);

// How long the start-up of a rotor that rests when it is measured takes from the run request to standstill under control, in
// seconds. One that swings is measured again.
double startup_time(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &as_written);

} // namespace nf
