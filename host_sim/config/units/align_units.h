/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the alignment, and how long it takes.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

align_cfg_t make_align(const MotorSettings &motor, const BoardSettings &board,
                       const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                       const Bases &b);

// Seconds of its parts, for a rotor that swings with so many rad/s: until it is pulled in, until it
// rests, and of both measurements.
double align_pull_time_s(double swing, const Bases &b);
double align_settle_time_s(double swing);
double align_measure_time_s(double swing, const Bases &b);

} // namespace nf
