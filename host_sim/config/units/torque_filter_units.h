/* SPDX-License-Identifier: MIT */
// Notch and low-pass of the torque current: the firmware's numbers of their frequencies, and what
// they do to a frequency.
#pragma once

#include "bases.h"

#include <complex>

namespace nf
{

bool has_torque_filter(const TuningSettings &tuning);

// Periods of the speed loop in a second: the filter's sample rate.
double speed_loop_rate(const TuningSettings &tuning, double control_period_s);

// Refuses frequencies that the speed loop's rate does not reach.
torque_filter_cfg_t make_torque_filter(const TuningSettings &tuning, const Bases &b);

// The filter's gain and phase at `hz`.
std::complex<double> torque_filter_response(const TuningSettings &tuning, double rate_hz,
                                            double hz);

} // namespace nf
