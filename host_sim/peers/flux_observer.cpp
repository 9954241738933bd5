// SPDX-License-Identifier: MIT
#include "flux_observer.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{
namespace
{

// Of the magnitude; a shorter vector shows no angle.
constexpr double LEAST_FLUX = 1e-3;

// Of the active flux, Wb.
double magnitude(const Model &model, Complex current_a, double angle_rad)
{
    const double current_d = (current_a * turn(-angle_rad)).real();
    return model.flux_wb + (model.inductance_d_h - model.inductance_q_h) * current_d;
}

} // namespace

FluxObserver::FluxObserver(double correction, const Pll &pll) : correction_(correction), pll_(pll)
{
}

void FluxObserver::start(const Model &model, const Estimate &known, Complex current_a)
{
    current_ = current_a;
    follow(model, known);
}

// At standstill the integral would drift: it begins anew from the known angle of this instant.
void FluxObserver::follow(const Model &model, const Estimate &known)
{
    const double angle = known.angle_rad - known.speed_rad_s * model.period_s;
    pll_.set(known);
    flux_ = model.inductance_q_h * current_ + magnitude(model, current_, angle) * turn(angle);
}

Estimate FluxObserver::step(const Model &model, const Sample &sample)
{
    const Complex drop = model.resistance_ohm * (current_ + sample.current_a) / 2.0;
    current_ = sample.current_a;
    flux_ += model.period_s * (sample.voltage_v - drop);
    const double known = magnitude(model, current_, pll_.now().angle_rad);
    const Complex active = flux_ - model.inductance_q_h * current_;
    const double excess = 1 - std::norm(active) / (known * known);
    flux_ += correction_ / 2 * excess * active;
    const Complex ahead = active * turn(-pll_.now().angle_rad);
    return pll_.step(model, ahead.imag() / std::max(std::abs(ahead), LEAST_FLUX * known));
}

} // namespace nf::peers
