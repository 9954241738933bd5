/* SPDX-License-Identifier: MIT */
// How far i_d weakens the field, and up to which speed that is enough.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

// The largest −i_d that field weakening asks for: its share of the largest current, and no more
// than the magnets bear.
double deepest_current(const MotorSettings &motor, const TuningSettings &tuning);

// Refuses a highest speed beyond the voltage that is left of the EMF when i_d weakens the field as
// far as it may, within the circle of the nominal bus; and one at which the observer's small angle
// of a PWM period is none.
void check_speed(const MotorSettings &motor, const BoardSettings &board,
                 const TuningSettings &tuning, const Model &m, const Bases &b);

} // namespace nf
