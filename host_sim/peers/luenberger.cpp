// SPDX-License-Identifier: MIT
#include "luenberger.h"

#include "back_emf.h"

#include <cmath>

namespace nf::peers
{

Luenberger::Luenberger(double bandwidth, const Pll &pll) : pole_(std::exp(-bandwidth)), pll_(pll)
{
}

void Luenberger::start(const Model &model, const Estimate &known, Complex current_a)
{
    const double turned = known.speed_rad_s * model.period_s;
    pll_.set(known);
    current_ = current_a;
    innovation_ = 0;
    emf_ = J * known.speed_rad_s * model.flux_wb * turn(known.angle_rad - turned) * lag(turned);
}

// By how much the observer turns an EMF back.
Complex Luenberger::lag(double turn_rad) const
{
    const Complex shown = 1.0 / (turn(turn_rad) - pole_);
    return turn(1.5 * turn_rad) * shown * shown / std::norm(shown);
}

Estimate Luenberger::step(const Model &model, const Sample &sample)
{
    const Winding winding(model);
    const double speed = pll_.now().speed_rad_s;
    const double k1 = winding.decay + 1 - 2 * pole_;
    const double k2 = -(1 - pole_) * (1 - pole_) / winding.gain;
    const Complex middle = sample.current_a * turn(-speed * model.period_s / 2);
    const Complex across = sample.voltage_v + saliency_voltage(model, speed, middle) - emf_;
    current_ = winding.decay * current_ + winding.gain * across + k1 * innovation_;
    emf_ += k2 * innovation_;
    innovation_ = sample.current_a - current_;
    const Complex next = emf_ + k2 * innovation_;
    const Complex emf = next * std::conj(lag(speed * model.period_s));
    return pll_.step(model, emf_angle_error(model, emf, pll_.now(), sample.course_rad_s));
}

void Luenberger::follow(const Model & /*model*/, const Estimate &known)
{
    pll_.set(known);
}

} // namespace nf::peers
