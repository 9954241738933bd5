// SPDX-License-Identifier: MIT
#include "sliding_mode.h"

#include "back_emf.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{

SlidingMode::SlidingMode(const Gains &gains, const Pll &pll) : gains_(gains), pll_(pll)
{
}

void SlidingMode::start(const Model &model, const Estimate &known, Complex current_a)
{
    const double turned = known.speed_rad_s * model.period_s;
    pll_.set(known);
    current_ = current_a;
    switched_ = J * known.speed_rad_s * model.flux_wb * turn(known.angle_rad - turned);
    emf_ = switched_ * lag(Winding(model).decay, turned);
}

// By how much the observer and its low-pass turn an EMF back.
Complex SlidingMode::lag(double decay, double turn_rad) const
{
    const Complex before = turn(-turn_rad); // one sample ago
    const Complex layer =
        gains_.layer * turn(-turn_rad / 2) / (1.0 - (decay - gains_.layer) * before);
    const Complex filter = gains_.filter / (1.0 - (1 - gains_.filter) * before);
    const Complex both = layer * filter;
    return both / std::abs(both);
}

Estimate SlidingMode::step(const Model &model, const Sample &sample)
{
    const Winding winding(model);
    const double speed = pll_.now().speed_rad_s;
    const double amplitude = gains_.amplitude * model.flux_wb * model.speed_limit_rad_s;
    const double slope = gains_.layer / winding.gain; // V per A
    const auto saturated = [&](double error) {
        return std::clamp(slope * error, -amplitude, amplitude);
    };
    const Complex middle = sample.current_a * turn(-speed * model.period_s / 2);
    const Complex across = sample.voltage_v + saliency_voltage(model, speed, middle) - switched_;
    current_ = winding.decay * current_ + winding.gain * across;
    const Complex error = current_ - sample.current_a;
    switched_ = {saturated(error.real()), saturated(error.imag())};
    emf_ += gains_.filter * (switched_ - emf_);
    const Complex emf = emf_ * std::conj(lag(winding.decay, speed * model.period_s));
    return pll_.step(model, emf_angle_error(model, emf, pll_.now(), sample.course_rad_s));
}

void SlidingMode::follow(const Model & /*model*/, const Estimate &known)
{
    pll_.set(known);
}

} // namespace nf::peers
