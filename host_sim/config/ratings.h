// Whether motor, board and tuning can do together what the motor's file says it is rated for.
#pragma once

#include "config.h"

namespace nf
{

// Notes a line each in config.scenario.notes: a rated torque that motor.max_current_a does not make, a rated point that
// the bus does not reach, and a κ too small at the highest speed for the published law, which has no proportional path.
void note_ratings(Config &config);

} // namespace nf
