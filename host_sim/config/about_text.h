/* SPDX-License-Identifier: MIT */
// The parts of about_t as a header has them, which a configuration block and the identity of a
// board have too.
#pragma once

#include "configuration.h"

#include <cstdint>
#include <string>

namespace nf
{

// "neurofoc: MOTOR, BOARD, TUNING", plain characters that need no quoting in C.
std::string about_name(const Config &config);

// The control tick, as the timer makes it of a whole number of its counts.
std::uint32_t tick_ps(const BoardSettings &board);

std::int32_t speed_max_rpm(const MotorSettings &motor);

// The initialisers that are facts of the board alone, behind the tick.
std::string about_board(const BoardSettings &board);

} // namespace nf
