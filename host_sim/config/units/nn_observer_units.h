/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the observer.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

nn_observer_cfg_t make_observer(const MotorSettings &motor, const BoardSettings &board,
                                const TuningSettings &tuning, const Model &m, const Bases &b);

// The estimate follows a ramp of speed with this delay, T·κ_p/κ. None with the published law, and
// with a sensor.
double estimate_lag_s(const TuningSettings &tuning, double period_s);

} // namespace nf
