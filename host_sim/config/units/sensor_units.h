/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the sensor of the shaft.
#pragma once

#include "bases.h"

namespace nf
{

sensor_cfg_t make_sensor(const MotorSettings &motor, const TuningSettings &tuning, const Bases &b);

// The patterns of the sectors, as the firmware has them. Six of them.
uint32_t hall_patterns(const SensorSettings &sensor);

// The speeds between which sensor and observer change, % of rated speed; 0: they do not.
struct SensorSpan {
    double observer_above_pct;
    double sensor_below_pct;
};
SensorSpan sensor_span(const MotorSettings &motor, const TuningSettings &tuning);

} // namespace nf
