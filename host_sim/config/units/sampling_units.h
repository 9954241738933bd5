/* SPDX-License-Identifier: MIT */
// The firmware's numbers of what is sampled, and with what angle.
#pragma once

#include "bases.h"

namespace nf
{

// Nothing to refuse: the ranges of the keys are those of the fields.
sampling_cfg_t make_sampling(const MotorSettings &motor, const BoardSettings &board,
                             const TuningSettings &tuning);

// From the first tick until the drive runs: INIT, 2^offset_samples_log2 ticks of calibration, and
// the slow period in which the command is taken.
double calibration_time(const BoardSettings &board, const TuningSettings &tuning);

// With an angle sensor nothing is to be found at the start, and the observer's speed is not
// trained.
TuningSettings for_sensor(const TuningSettings &tuning);

} // namespace nf
