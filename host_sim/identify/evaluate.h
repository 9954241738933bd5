/* SPDX-License-Identifier: MIT */
// The values of a motor, with error bars, from the records of its identification.
#pragma once

#include "records.h"

#include "settings.h"

#include <optional>
#include <string>
#include <vector>

namespace nf::identify
{

// What the records do not say.
struct Known {
    MotorSettings plate;                // config/plate.h; of a motor that is known, what is known is not read
    std::optional<BoardSettings> board; // else a converter of 12 bits and a duty margin of 5 % are assumed
    double temperature_c = 25;          // of the winding
    double current_gain_pct = 0;        // how far the gain that all current sensors share may be wrong, ±
    double bus_gain_pct = 0;            // likewise of the bus voltage
};

struct Result {
    MotorSettings motor;       // the plate with what was measured
    MeasuredSettings measured; // its error bars, what the legs lose, and the conditions
    std::vector<std::string> remarks; // for the user, a sentence each: what was assumed, left out, or does not agree
};

// R, L_d without current, L_q at the continuous current, φ, J, friction, loss of the legs. Rated torque is that of the
// continuous current across the flux, 1.5·P·φ·I. Rated speed is the highest with that current, to three digits, at which
// EMF, voltage of R and L_q, and loss of the legs fit the bus of the measurement; at most the plate's.
//
// Gains that all sensors share change all values and show in none: known.current_gain_pct and bus_gain_pct are added to the
// bounds. Throws ConfigError, one line that begins with `name`, for records that do not hold what a value needs.
Result evaluate(const Records &records, const Known &known, const std::string &name);

} // namespace nf::identify
