/* SPDX-License-Identifier: MIT */
// Up to which speed opening the gates is safe, and what the short circuit above it takes.
#pragma once

#include "bases.h"

namespace nf
{

// The over-speed fault opens the gates this much above the highest speed; the observer's own limit
// is above it.
constexpr double OVERSPEED_SHARE = 1.15;

// Electrical rad/s up to which the bus stays within acting_bus_limit() when the gates open,
// whatever current flows then. See docs/protection.md.
double safe_open_speed(const MotorSettings &motor, const BoardSettings &board);

// Amplitude of the current in the short circuit at this electrical speed, in the end.
double short_circuit_current(const MotorSettings &motor, double speed_el);

// Its largest value behind a short circuit from any point of operation, at any speed from
// safe_open_speed() to speed_el.
double short_circuit_peak(const MotorSettings &motor, const BoardSettings &board, double speed_el);

// The bus in V beyond which the drive acts. With board.safe_state = "short" it is below
// board.bus_max_v by what the largest current charges until the short circuit is there, because the
// bus may be the only sign of a fast rotor.
double acting_bus_limit(const BoardSettings &board);

// Refuses a highest speed at which no state of the gates is safe.
safe_state_cfg_t make_safe_state(const MotorSettings &motor, const BoardSettings &board,
                                 const Bases &b);

} // namespace nf
