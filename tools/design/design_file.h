/* SPDX-License-Identifier: MIT */
// A design as read from its file: the motor, the nominal point, the cost, the start, pairs of gains
// to look at, and where the matrices of a publication are.
#pragma once

#include "config.h"
#include "cost.h"
#include "linear_model.h"

#include <string>
#include <vector>

namespace nf::design
{

// [optimum] The weights and the horizon are those of the cost.
struct OptimumSettings {
    CostSettings cost;
    double slowest_time_constant_s = 0;
    Gains start = {0, 0};
};

struct DesignSettings {
    std::string file; // as shown to the user
    Config inputs;    // the motor; among its sources every file that was read
    NominalPoint nominal;
    OptimumSettings optimum;
    Gains arbitrary = {0, 0};     // [arbitrary] of the figures 4a, 5a
    Gains published = {0, 0};     // [published] of the figures 4b, 5b, 6
    double response_s = 6;        // length of the step responses
    std::string matrices;         // path of the published matrices, or empty
    bool foreign_nominal = false; // the motor is an override, the nominal point is not
};

// A design by its name in tools/design/designs or by a path. Overrides are "section.key=value",
// "motor.key=value" and "motor=NAME". Throws ConfigError for whatever is wrong.
DesignSettings read_design(const std::string &design, const std::vector<std::string> &set = {});

// Refuses a pair that the keys of [start] do not allow. `place` is for the message.
void check_gains(const Gains &gains, const std::string &place);

// Every key with its range, default and meaning, a line each.
std::string key_list();

// The words for a state and an input in the files.
const std::vector<std::string> &state_words();
const std::vector<std::string> &input_words();

} // namespace nf::design
