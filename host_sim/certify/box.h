/* SPDX-License-Identifier: MIT */
// Within what a real machine may lie: each value that nobody knows exactly, with its range.
#pragma once

#include "config.h"

#include <functional>
#include <string>
#include <vector>

namespace nf::certify
{

// Where the range of an axis is from.
enum class Ground {
    measured,  // [measured] of the motor file
    typical,   // nobody states it
    operation, // what the machine is used for, no error
};
const char *ground_text(Ground ground);

// One value and its range, both ends in the unit that people read.
struct Axis {
    std::string key;   // that of a file, or of certify itself
    std::string title; // a few words
    std::string unit;
    double low;
    double high;
    Ground ground;
    std::string better; // one sentence: how to know it better; empty for what is no error
    // Gives a real machine this value. Its timetable is there already.
    std::function<void(Config &real, double value)> set;
};

// `config` is what the drive believes. A value without a range, as a dead time of 0, has no axis.
//
//   R, L_d, L_q, φ, J, friction   [measured]: 2·std + bound, twice a bar that is both; else ±10, 20, 20, 5, 30, 50 %
//   Coulomb friction, dead time,  likewise; else 0 to 5 % of rated torque, ±20 %, half to twice, 0.5 to 1.5 LSB
//     knee, noise of the sensors
//   mismatch, gain of the current sensors: likewise, else ±1 %; ±2 %
//   gain of the bus measurement, supply, oscillator: ±2 %, ±5 %, ±1 %
//   load from the start on, load step, inertia of a load that is added: 0 to 50 % and 100 % of rated torque, 100 % of J
//   rotor angle at the start: any
std::vector<Axis> box_of(const Config &config);

// The largest inertia in the box.
double most_inertia(const std::vector<Axis> &box);

} // namespace nf::certify
