/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the control of an imposed current: soft, so that the windings damp the
// rotor.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

// K_p of the imposed current's control, in ohm, which adds to R: both together damp the swing as
// wanted. Below the swing's ω_n·L_q the current lags behind the EMF and damps less; below a share
// of V_dt/I the errors of the dead-time compensation set the current.
double hold_gain_ohm(const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning, const ModelScales &scales, const Model &m);

// Current control of an imposed current, given that of RUN.
current_loop_cfg_t make_hold_loop(const current_loop_cfg_t &run_loop, const MotorSettings &motor,
                                  const BoardSettings &board, const TuningSettings &tuning,
                                  const ModelScales &scales, const Model &m, const Bases &b);

} // namespace nf
