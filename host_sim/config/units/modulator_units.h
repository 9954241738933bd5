/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the modulator and of what the legs lose.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

modulator_cfg_t make_modulator(const BoardSettings &board, const TuningSettings &tuning,
                               const ModelScales &model, const Model &m, const Bases &b);

// The largest phase voltage as a share of the bus: the circle in the hexagon of the inverter.
double largest_ratio(const BoardSettings &board);

// The vector that dead time and device drop take off the voltage: its first harmonic is 4/3 of what
// a leg loses.
double leg_loss_v(const BoardSettings &board, double dead_time_s, double device_drop_v);

// The current that charges the capacitance of a leg's output just within the dead time, as the
// drive takes both; 0 without dead time.
double commutation_knee_a(const BoardSettings &board, const ModelScales &model);

} // namespace nf
