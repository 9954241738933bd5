/* SPDX-License-Identifier: MIT */
// A recorded fault in the words and units of a person.
#pragma once

#include "found_fault.h"

#include <string>

namespace nf
{

// "OVERCURRENT@1234 (0.1034 s)": name, tick since the first and the scenario's time.
std::string fault_mark(const fault_t &fault, double time_s);

// "OVERVOLTAGE: 401.2 V, limit 400 V", "OSCILLATION: 10 A at 116.3 Hz, limit 2.52 A", values in SI
// units. A temperature is in °C by the board's line; where no board is given it is the sensor's
// count.
std::string fault_measure(const FoundFault &fault, const Bases &bases,
                          const BoardSettings *board = nullptr);

} // namespace nf
