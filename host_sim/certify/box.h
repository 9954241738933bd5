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
//   value                        by [measured]      where that says nothing
//   R, L_d, L_q, φ, J, friction  the error bar      ±10, 20, 20, 5, 30, 50 %
//   Coulomb friction             the error bar      0 to 5 % of rated torque
//   dead time, knee              the error bar      ±20 %, half to twice
//   mismatch of the sensors      the error bar      ±1 %
//   noise of the sensors         half to 1½ times   0.5 to 1.5 LSB
//   gain of current and bus measurement             ±2 %
//   supply, oscillator                              ±5, 1 %
//   load from the start on, load step               0 to 50, 100 % of rated torque
//   inertia of a load that is added                 0 to 100 % of J
//   rotor angle at the start                        any
//
// A value is drawn evenly: its bar is where it lies in 95 of 100 cases, and all of the bar counts
// the same.
std::vector<Axis> box_of(const Config &config);

// The largest inertia in the box.
double most_inertia(const std::vector<Axis> &box);

} // namespace nf::certify
