/* SPDX-License-Identifier: MIT */
// Paper B (30)–(38): the motor with its speed controller; (44)–(49): with the phase states too.
#pragma once

#include "matrices.h"

namespace nf::design
{

// (35).
struct Loop {
    LoopMatrix a; // (37); its fifth row is (33)
    LoopInputs b; // (38)
};

Loop close_loop(const Discrete &motor, const Gains &gains);

// (34): Δω_s from the state and the speed command.
double controller_output(const Discrete &motor, const Gains &gains, const LoopState &state,
                         double command_rad_s);

// (46) behind the states of the speed loop.
enum PhaseState {
    ALPHA = STATE_COUNT, // rad, Δα_r
    THETA,               // rad, Δθ_s
    PHASE_STATE_COUNT
};

using PhaseMatrix = Eigen::Matrix<double, PHASE_STATE_COUNT, PHASE_STATE_COUNT>;
using PhaseVector = Eigen::Matrix<double, PHASE_STATE_COUNT, 1>;
using PhaseInputs = Eigen::Matrix<double, PHASE_STATE_COUNT, INPUT_COUNT>;

// (45).
struct PhaseLoop {
    PhaseMatrix a; // (48)
    PhaseInputs b; // (49)
};

// The print of (48) has K_i·T where (43) and (44) have K_2·T; K_2·T it is. As printed, α_r holds
// what it starts with and nothing of the motor depends on α_r or θ_s: the two poles at 1 are
// theirs.
PhaseLoop add_phase_states(const Discrete &motor, const Gains &gains, double k2);

} // namespace nf::design
