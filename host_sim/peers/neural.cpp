// SPDX-License-Identifier: MIT
#include "neural.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{
namespace
{

double rho_at(const Model &m, double speed_rad_s, double limit, double feedback)
{
    const bool slow = std::abs(speed_rad_s) < m.speed_min_rad_s;
    const double corner = m.resistance_ohm / m.inductance_d_h + feedback / m.period_s;
    return slow ? 0.0 : std::clamp(corner / speed_rad_s, -limit, limit);
}

// î_d + j·î_q of x̂ + j·ŷ
Complex current_of(const Model &m, Complex state)
{
    return {state.real() - m.flux_wb / m.inductance_d_h,
            state.imag() * m.inductance_d_h / m.inductance_q_h};
}

} // namespace

Neural::Neural(const Gains &gains) : gains_(gains)
{
}

void Neural::start(const Model &model, const Estimate &known, Complex current_a)
{
    now_ = known;
    speed_out_ = known.speed_rad_s;
    angle_before_ = known.angle_rad - known.speed_rad_s * model.period_s;
    error_ = 0;
    const Complex current = current_a * turn(-angle_before_);
    const double saliency = model.inductance_q_h / model.inductance_d_h;
    state_ =
        Complex(current.real() + model.flux_wb / model.inductance_d_h, saliency * current.imag()) *
        turn(angle_before_);
}

Estimate Neural::step(const Model &model, const Sample &sample)
{
    const double period = model.period_s;
    const double shift = model.flux_wb / model.inductance_d_h;
    const Complex before = state_ * turn(-angle_before_);
    const Complex middle = turn(angle_before_ + speed_out_ * period / 2);
    const Complex drop = model.resistance_ohm * current_of(model, before) * middle;
    state_ += period / model.inductance_d_h * (sample.voltage_v - drop) + // (14)–(16)
              gains_.feedback * error_ * middle;
    const Complex frame = turn(-now_.angle_rad);
    const Complex error = sample.current_a * frame - current_of(model, state_ * frame); // (17)
    error_ = error;
    const Complex flux_error(error.real(),
                             error.imag() * model.inductance_q_h / model.inductance_d_h);
    const double rho = rho_at(model, sample.course_rad_s, gains_.rho_max, gains_.feedback);
    const Complex turned = flux_error * Complex(1, -rho);
    const double gradient =
        (turned.imag() * before.real() - turned.real() * before.imag()) / (shift * shift);
    now_.speed_rad_s = std::clamp(now_.speed_rad_s - gains_.kappa / period * gradient,
                                  -model.speed_limit_rad_s, model.speed_limit_rad_s); // (21), (22)
    speed_out_ = now_.speed_rad_s - gains_.kappa_p / period * gradient;
    angle_before_ = now_.angle_rad;
    now_.angle_rad =
        std::remainder(now_.angle_rad + period * speed_out_, 2 * std::acos(-1.0)); // (23)
    return now_;
}

void Neural::follow(const Model & /*model*/, const Estimate &known)
{
    now_ = known;
    speed_out_ = known.speed_rad_s;
}

} // namespace nf::peers
