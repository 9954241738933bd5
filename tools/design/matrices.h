/* SPDX-License-Identifier: MIT */
// The linear model's variables in the paper's order, and the matrices made of them.
#pragma once

#include <Eigen/Dense>

namespace nf::design
{

// Paper B (46) and (36); deviations from the nominal point.
enum State {
    I_Q,      // A
    I_D,      // A
    SPEED,    // rad/s, the paper's ω_r
    ANGLE,    // rad, torque angle δ
    INTEGRAL, // rad/s, sum of past speed errors over the samples
    STATE_COUNT
};
constexpr int MOTOR_STATES = 4; // those before the controller's

// Paper B (47).
enum Input {
    LOAD,   // N·m, against the motion
    SUPPLY, // rad/s, supply frequency ω_s, the controller's output; of the closed loop, its command
    INPUT_COUNT
};

using MotorMatrix = Eigen::Matrix<double, MOTOR_STATES, MOTOR_STATES>;
using MotorInputs = Eigen::Matrix<double, MOTOR_STATES, INPUT_COUNT>;
using LoopMatrix = Eigen::Matrix<double, STATE_COUNT, STATE_COUNT>;
using LoopInputs = Eigen::Matrix<double, STATE_COUNT, INPUT_COUNT>;
using LoopState = Eigen::Matrix<double, STATE_COUNT, 1>;

// Paper B (25).
struct Discrete {
    MotorMatrix phi;
    MotorInputs theta;
    double sample_time_s;
};

// Of the speed controller (28): K_p is a number, K_i is 1/s.
struct Gains {
    double kp;
    double ki_per_s;
};

} // namespace nf::design
