// SPDX-License-Identifier: MIT
#include "conjugate_gradient.h"

namespace nf::design
{
namespace
{

constexpr double FIRST_STEP = 1e-3; // length of the first trial
constexpr int DOUBLINGS = 60;
constexpr int BISECTIONS = 60;

// Whether the minimum along a line is beyond a point of it.
class Line
{
public:
    Line(const Objective &objective, const Eigen::VectorXd &from, const Eigen::VectorXd &direction)
        : objective_(objective), from_(from), direction_(direction), value_(objective.value(from))
    {
    }

    Eigen::VectorXd point(double step) const
    {
        return from_ + step * direction_;
    }

    bool goes_on_down(double step) const
    {
        const Eigen::VectorXd x = point(step);
        return objective_.allowed(x) && objective_.value(x) <= value_ &&
               objective_.gradient(x).dot(direction_) < 0;
    }

private:
    const Objective &objective_;
    const Eigen::VectorXd &from_;
    const Eigen::VectorXd &direction_;
    double value_;
};

// Step 3: the step to the line's first minimum. 0 where none is found.
double step_size(const Line &line, double first)
{
    double good = 0;
    double bad = first;
    for (int k = 0; k < DOUBLINGS && line.goes_on_down(bad); k++) {
        good = bad;
        bad *= 2;
    }
    for (int k = 0; k < BISECTIONS; k++) {
        const double middle = (good + bad) / 2;
        (line.goes_on_down(middle) ? good : bad) = middle;
    }
    return good;
}

} // namespace

Descent conjugate_gradient(const Objective &objective, const Eigen::VectorXd &start,
                           const DescentLimits &limits,
                           const std::function<bool(const Eigen::VectorXd &)> &stop)
{
    Eigen::VectorXd at = start;
    Eigen::VectorXd gradient = objective.gradient(at);
    Eigen::VectorXd direction = -gradient; // (55)
    Eigen::Index since_restart = 0;
    int iterations = 0;
    bool stuck = false;
    while (gradient.norm() > limits.tolerance && iterations < limits.iterations && !stuck) {
        const Line line(objective, at, direction);
        const double step = step_size(line, FIRST_STEP / direction.norm());
        stuck = !(step > 0) && since_restart == 0;
        at = line.point(step).eval(); // step 4
        const Eigen::VectorXd before = gradient;
        gradient = objective.gradient(at);
        since_restart++;
        const double beta = gradient.squaredNorm() / before.squaredNorm(); // (60)
        direction = -gradient + beta * direction;                          // (56)
        if (since_restart >= at.size() || !(step > 0) || direction.dot(gradient) >= 0) {
            direction = -gradient;
            since_restart = 0;
        }
        iterations++;
        if (stop && stop(at)) {
            break;
        }
    }
    const double norm = gradient.norm();
    return {at, objective.value(at), norm, iterations, norm <= limits.tolerance};
}

} // namespace nf::design
