/* SPDX-License-Identifier: MIT */
// The power stage's temperature sensor: the line that the board file gives.
#pragma once

#include "settings.h"

namespace nf
{

// Counts of the power stage's temperature sensor, not rounded; beyond the converter's ends where
// the temperature is.
double temperature_count(const BoardSettings &board, double temperature_c);

// The other way: °C at a count; beyond the first and the last point their line goes on.
double temperature_at(const BoardSettings &board, double count);

} // namespace nf
