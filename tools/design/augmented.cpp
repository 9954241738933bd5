// SPDX-License-Identifier: MIT
#include "augmented.h"

namespace nf::design
{

Loop close_loop(const Discrete &motor, const Gains &gains)
{
    const double ki_t = gains.ki_per_s * motor.sample_time_s;
    const double direct = gains.kp + ki_t; // (29)
    const auto supply = motor.theta.col(SUPPLY);
    Loop loop;
    loop.a.setZero();
    loop.a.topLeftCorner<MOTOR_STATES, MOTOR_STATES>() = motor.phi;
    loop.a.col(SPEED).head<MOTOR_STATES>() -= supply * direct;
    loop.a.col(INTEGRAL).head<MOTOR_STATES>() = supply * ki_t;
    loop.a(INTEGRAL, SPEED) = -1; // (33)
    loop.a(INTEGRAL, INTEGRAL) = 1;
    loop.b.setZero();
    loop.b.col(LOAD).head<MOTOR_STATES>() = motor.theta.col(LOAD);
    loop.b.col(SUPPLY).head<MOTOR_STATES>() = supply * direct;
    loop.b(INTEGRAL, SUPPLY) = 1;
    return loop;
}

double controller_output(const Discrete &motor, const Gains &gains, const LoopState &state,
                         double command_rad_s)
{
    const double ki_t = gains.ki_per_s * motor.sample_time_s;
    return ki_t * state[INTEGRAL] + (gains.kp + ki_t) * (command_rad_s - state[SPEED]);
}

PhaseLoop add_phase_states(const Discrete &motor, const Gains &gains, double k2)
{
    const Loop loop = close_loop(motor, gains);
    PhaseLoop phase;
    phase.a.setZero();
    phase.a.topLeftCorner<STATE_COUNT, STATE_COUNT>() = loop.a;
    phase.a(ALPHA, ALPHA) = 1;                        // (41)
    phase.a(THETA, SPEED) = k2 * motor.sample_time_s; // (43)
    phase.a(THETA, ALPHA) = 1;
    phase.a(THETA, THETA) = 1;
    phase.b.setZero();
    phase.b.topRows<STATE_COUNT>() = loop.b;
    return phase;
}

} // namespace nf::design
