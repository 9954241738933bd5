/* SPDX-License-Identifier: MIT */
// The current that a start imposes: how large it is at rest and in motion, and how the rotor swings
// in its field.
#pragma once

#include "bases.h"
#include "motor_model.h"

#include <cstdint>

namespace nf
{

// The largest current along the flux that is imposed, at rest and in motion, and in RUN. The
// observer sees the angle by the same active flux.
double stiff_current(const MotorSettings &motor);

// At rest.
double hold_current(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &tuning);

// In motion: what the motor bears, within what its saliency allows and its EMF can be seen beside;
// never less than at rest, or a load would be lost.
double moving_current(const MotorSettings &motor, const BoardSettings &board,
                      const TuningSettings &tuning);

// ψ/φ: what is left of the flux that a swing moves past an imposed current, as the reluctance takes
// (L_q − L_d)·I off it. A half at least, by stiff_current().
double active_share(double current_a, const MotorSettings &motor);

// ω_n of the rotor in the field of the current at rest, rad/s: J/P·δ'' = −1.5·P·ψ·I·δ with the
// active flux ψ.
double swing_rad_s(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m);

// The imposed current's change in a tick: it rises in the rotor's own time.
int32_t hold_slope(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m, const Bases &b);

// Of the hand-over to the observer, electrical.
double handover_rad_s(const MotorSettings &motor, const TuningSettings &tuning);

// A count of the converter.
double count_a(const BoardSettings &board);

// Q15: less than a count of a 12-bit converter is no current.
constexpr double HOLD_MIN = 8;

} // namespace nf
