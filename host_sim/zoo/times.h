/* SPDX-License-Identifier: MIT */
// When what happens in a run of any motor: long enough for the slowest drive that its ratings
// allow.
#pragma once

#include "specimen.h"

namespace nf::zoo
{

// The last speed, a share of the rated one.
constexpr double LAST_SPEED = 0.1;

// In seconds after the drive was asked to run.
struct Times {
    double held;     // the imposed current holds a load
    double started;  // the start-up is over: 55 %
    double full;     // 100 %
    double loaded;   // half of the rated torque on
    double unloaded; // and off
    double stopped;  // standstill
    double reversed; // −10 %
    double end;
};

// Of a motor on a board with this PWM frequency. R, L and friction do not matter.
Times times_of(const Motor &motor, double pwm_frequency_hz);

} // namespace nf::zoo
