/* SPDX-License-Identifier: MIT */
// Extended Kalman filter with four states [Bolognani 1999]: here stator flux linkage λ_α, λ_β,
// speed and angle. With flux in place of current the prediction needs no rotation and saliency is
// exact:
//     λ(k+1) = λ(k) + T·(v − R·i),  ω(k+1) = ω(k),  θ(k+1) = θ(k) + T·ω
//     i = exp(jθ)·L⁻¹·(exp(−jθ)·λ − φ)                the measurement
//
// [Bolognani 1999] S. Bolognani, R. Oboe, M. Zigliotto: Sensorless full-digital PMSM drive with EKF
// estimation of speed and rotor position. IEEE Trans. Ind. Electron. 46 (1), 1999.
#pragma once

#include "estimator.h"

#include <Eigen/Dense>

namespace nf::peers
{

class Kalman : public Estimator
{
public:
    // Noise of the states in a sample over that of the measured current, as currents: of the flux
    // over L_d, of the angle times φ/L_d, of the turn in a sample times φ/L_d.
    struct Gains {
        double flux;
        double angle;
        double speed;
    };

    explicit Kalman(const Gains &gains);

    void start(const Model &model, const Estimate &known, Complex current_a) override;
    Estimate step(const Model &model, const Sample &sample) override;
    void follow(const Model &model, const Estimate &known) override;

private:
    using State = Eigen::Vector4d; // λ_α, λ_β, ω, θ
    using Covariance = Eigen::Matrix4d;

    void predict(const Model &model, Complex voltage_v);
    void correct(const Model &model, Complex current_a);
    void trust_motion(const Model &model);

    Gains gains_;
    State state_ = State::Zero(); // of the last sample
    Covariance covariance_ = Covariance::Zero();
    bool led_ = true;
};

} // namespace nf::peers
