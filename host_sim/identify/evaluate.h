/* SPDX-License-Identifier: MIT */
// A motor of the records of its identification.
#pragma once

#include "config.h"
#include "hall_fit.h"

#include <string>
#include <vector>

namespace nf::identify
{

struct Result {
    MotorSettings motor;       // complete: the name plate, and what was measured
    MeasuredSettings measured; // error bars and conditions
    double lost_time_s = 0;    // of a leg at the continuous current
    double lost_time_bar_s = 0;
    double knee_bar_a = 0; // of a knee that is not seen too
    double noise_bar_lsb = 0;
    Inductances inductances; // over the current
    Flux flux;               // both ways to it
    Halls halls;             // neither measured nor in trouble: the motor has no Hall sensors
    std::vector<std::string>
        remarks; // a line each, for a person: what does not fit, what was not seen
};

// plate: as load_plate() has read it, with the board of the records. temperature_c: of the winding.
// Throws ConfigError, one line, where the records do not go with the files or end too early.
Result evaluate(const Records &sent, const Config &plate, double temperature_c);

} // namespace nf::identify
