// SPDX-License-Identifier: MIT
#include "cost.h"

#include <vector>

namespace nf::design
{
namespace
{

// (52): the loop's states and the cost so far.
constexpr int COST = STATE_COUNT;
constexpr int EXTENDED = STATE_COUNT + 1;
using Extended = Eigen::Matrix<double, EXTENDED, 1>;
using Jacobian = Eigen::Matrix<double, EXTENDED, EXTENDED>;
using GainJacobian = Eigen::Matrix<double, EXTENDED, 2>;

class Trajectory
{
public:
    Trajectory(const Discrete &motor, const CostSettings &settings, const Gains &gains)
        : motor_(motor), settings_(settings), loop_(close_loop(motor, gains)), gains_(gains)
    {
        u_.setZero();
        u_[settings.input] = 1;
        target_ = settings.state == SPEED ? u_[SUPPLY] : 0;
    }

    double weighted(const Extended &x) const // X
    {
        return x[settings_.state] - target_;
    }

    double output(const Extended &x) const
    {
        return controller_output(motor_, gains_, x.head<STATE_COUNT>(), u_[SUPPLY]);
    }

    Extended next(const Extended &x) const // (53), of which (51) is the last row
    {
        const double off = weighted(x);
        const double supply = output(x);
        Extended after;
        after.head<STATE_COUNT>() = loop_.a * x.head<STATE_COUNT>() + loop_.b * u_;
        after[COST] = x[COST] + motor_.sample_time_s *
                                    (settings_.q1 * off * off + settings_.q2 * supply * supply);
        return after;
    }

    Jacobian by_state(const Extended &x) const // f_x, (59)
    {
        const double t = motor_.sample_time_s;
        const double supply_cost = 2 * t * settings_.q2 * output(x);
        Jacobian jacobian = Jacobian::Zero();
        jacobian.topLeftCorner<STATE_COUNT, STATE_COUNT>() = loop_.a;
        jacobian(COST, settings_.state) += 2 * t * settings_.q1 * weighted(x);
        jacobian(COST, SPEED) -= supply_cost * (gains_.kp + gains_.ki_per_s * t);
        jacobian(COST, INTEGRAL) += supply_cost * gains_.ki_per_s * t;
        jacobian(COST, COST) = 1;
        return jacobian;
    }

    GainJacobian by_gains(const Extended &x) const // f_z, (57)
    {
        const double t = motor_.sample_time_s;
        const double error = u_[SUPPLY] - x[SPEED];
        const Eigen::RowVector2d supply(error, t * (x[INTEGRAL] + error)); // dω_s/dz of (34)
        GainJacobian jacobian = GainJacobian::Zero();
        jacobian.topRows<MOTOR_STATES>() = motor_.theta.col(SUPPLY) * supply;
        jacobian.row(COST) = 2 * t * settings_.q2 * output(x) * supply;
        return jacobian;
    }

    std::vector<Extended> run() const
    {
        std::vector<Extended> states = {Extended::Zero()};
        for (int n = 0; n < settings_.horizon_samples; n++) {
            states.push_back(next(states.back()));
        }
        return states;
    }

private:
    const Discrete &motor_;
    const CostSettings &settings_;
    Loop loop_;
    Gains gains_;
    Eigen::Vector2d u_;
    double target_; // where X has to go
};

} // namespace

double cost(const Discrete &motor, const CostSettings &settings, const Gains &gains)
{
    const Trajectory trajectory(motor, settings, gains);
    const Extended last = trajectory.run().back();
    const double off = trajectory.weighted(last);
    return last[COST] + settings.q3 * off * off;
}

Eigen::Vector2d cost_gradient(const Discrete &motor, const CostSettings &settings,
                              const Gains &gains)
{
    const Trajectory trajectory(motor, settings, gains);
    const std::vector<Extended> states = trajectory.run();
    Extended adjoint = Extended::Zero(); // (58) at the horizon
    adjoint[settings.state] = 2 * settings.q3 * trajectory.weighted(states.back());
    adjoint[COST] = 1;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (auto state = states.rbegin() + 1; state != states.rend(); ++state) {
        gradient += trajectory.by_gains(*state).transpose() * adjoint;        // (54)
        adjoint = (trajectory.by_state(*state).transpose() * adjoint).eval(); // (58)
    }
    return gradient;
}

} // namespace nf::design
