/* SPDX-License-Identifier: MIT */
// Whether motor, board and tuning do together what each file says.
#pragma once

#include "configuration.h"

namespace nf
{

// Notes a line each in config.scenario.notes: a rated torque that motor.max_current_a does not
// make, a rated point that the bus does not reach, a κ too small at the highest speed for the
// published law, which has no proportional path, and a speed loop that is too fast for its torque
// filter.
void note_ratings(Config &config);

} // namespace nf
