// SPDX-License-Identifier: MIT
#include "kalman.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{
namespace
{

using Output = Eigen::Matrix<double, 2, 4>;

struct Current {
    Complex value;
    Output slope; // by the states
};

Complex inverse_inductance(const Model &m, Complex flux)
{
    return {flux.real() / m.inductance_d_h, flux.imag() / m.inductance_q_h};
}

Current current_of(const Model &m, const Eigen::Vector4d &state)
{
    const Complex frame = turn(state(3));
    const Complex flux = Complex(state(0), state(1)) * std::conj(frame);
    const Complex current = inverse_inductance(m, flux - m.flux_wb);
    Current c{frame * current, Output::Zero()};
    const auto store = [&](int column, Complex by) {
        c.slope.col(column) = Eigen::Vector2d(by.real(), by.imag());
    };
    store(0, frame * inverse_inductance(m, std::conj(frame)));
    store(1, frame * inverse_inductance(m, J * std::conj(frame)));
    store(3, frame * (J * current - inverse_inductance(m, J * flux)));
    return c;
}

} // namespace

Kalman::Kalman(const Gains &gains) : gains_(gains)
{
}

void Kalman::start(const Model &model, const Estimate &known, Complex current_a)
{
    const double angle = known.angle_rad - known.speed_rad_s * model.period_s;
    const Complex current = current_a * turn(-angle);
    const Complex flux = Complex(model.inductance_d_h * current.real() + model.flux_wb,
                                 model.inductance_q_h * current.imag()) *
                         turn(angle);
    state_ << flux.real(), flux.imag(), known.speed_rad_s, angle;
    covariance_ = (gains_.flux * model.inductance_d_h) * (gains_.flux * model.inductance_d_h) *
                  Covariance::Identity();
    led_ = true;
}

// Speed and angle are known: their uncertainty begins anew.
void Kalman::trust_motion(const Model &model)
{
    const double per_angle = model.inductance_d_h / model.flux_wb;
    covariance_.rightCols<2>().setZero();
    covariance_.bottomRows<2>().setZero();
    covariance_(2, 2) = std::pow(gains_.speed * per_angle / model.period_s, 2);
    covariance_(3, 3) = std::pow(gains_.angle * per_angle, 2);
    led_ = false;
}

void Kalman::predict(const Model &model, Complex voltage_v)
{
    const double period = model.period_s;
    const Current current = current_of(model, state_);
    // The drop turns half a period on.
    const Complex middle = turn(state_(2) * period / 2);
    const Complex change = period * (voltage_v - model.resistance_ohm * current.value * middle);
    Covariance slope = Covariance::Identity();
    slope.topRows<2>() -= period * model.resistance_ohm * current.slope;
    slope(3, 2) = period;
    state_ += State(change.real(), change.imag(), 0, period * state_(2));
    const double per_angle = model.inductance_d_h / model.flux_wb;
    const double flux = gains_.flux * model.inductance_d_h;
    const State noise(flux, flux, gains_.speed * per_angle / period, gains_.angle * per_angle);
    covariance_ = (slope * covariance_ * slope.transpose()).eval();
    covariance_.diagonal() += noise.cwiseAbs2();
}

void Kalman::correct(const Model &model, Complex current_a)
{
    const Current current = current_of(model, state_);
    const Complex innovation = current_a - current.value;
    const Eigen::Matrix<double, 4, 2> cross = covariance_ * current.slope.transpose();
    const Eigen::Matrix2d spread =
        current.slope * cross + Eigen::Matrix2d::Identity(); // 1 A² of noise
    const Eigen::Matrix<double, 4, 2> gain = cross * spread.inverse();
    state_ += gain * Eigen::Vector2d(innovation.real(), innovation.imag());
    covariance_ -= gain * cross.transpose();
    covariance_ = ((covariance_ + covariance_.transpose()) / 2).eval();
    state_(2) = std::clamp(state_(2), -model.speed_limit_rad_s, model.speed_limit_rad_s);
    state_(3) = std::remainder(state_(3), 2 * std::acos(-1.0));
}

Estimate Kalman::step(const Model &model, const Sample &sample)
{
    if (led_) {
        trust_motion(model);
    }
    predict(model, sample.voltage_v);
    correct(model, sample.current_a);
    return {state_(3) + state_(2) * model.period_s, state_(2)};
}

// The states are those of the last sample.
void Kalman::follow(const Model &model, const Estimate &known)
{
    state_(2) = known.speed_rad_s;
    state_(3) = known.angle_rad - known.speed_rad_s * model.period_s;
    led_ = true;
}

} // namespace nf::peers
