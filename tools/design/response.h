/* SPDX-License-Identifier: MIT */
// Step responses of the closed loop: the figures 4 to 6 of paper B.
#pragma once

#include "stability.h"

#include <string>
#include <vector>

namespace nf::design
{

// Deviations from the nominal point after a step of 1 at time 0, a value a sample.
struct Response {
    std::vector<double> time_s;
    std::vector<PhaseVector> states;  // (46)
    std::vector<double> output_rad_s; // the controller's Δω_s
};

// By (45), with both loops; `k2` is K_2 of (42).
Response step_response(const Discrete &motor, const Gains &gains, double k2, int input,
                       double duration_s);

// Where the states settle. A load step leaves currents, a speed step the speed itself.
LoopState settled(const Discrete &motor, const Gains &gains, int input);

// In time and size of a speed response.
struct ResponseFigures {
    double peak_rad_s; // farthest from where the speed settles
    double peak_time_s;
    double overshoot_rad_s; // on the other side of where it settles, or beyond it
    double rms_rad_s;       // from where it settles, over the response
    double envelope_s;      // time constant of the slowest mode that oscillates; 0 without one
    double slowest_s;       // time constant of the slowest mode
};

ResponseFigures figures(const Discrete &motor, const Gains &gains, int input,
                        const Response &response);

} // namespace nf::design
