/* SPDX-License-Identifier: MIT */
// Neural-network speed observer, paper A (14)–(22), in SI units and without any limit: with the
// exact rotation by W2, and as the paper prints it.
#pragma once

#include "twin_transforms.h"

#include <algorithm>

namespace nf::twin
{

class NnObserver
{
public:
    struct Params {
        double period_s;
        double resistance_ohm;
        double inductance_d_h;
        double inductance_q_h;
        double saliency; // L_q/L_d as it scales the error of i_q
        double flux_wb;
        double eta;           // learning rate of (19)
        double alpha;         // momentum of (19)
        double kappa_p;       // proportional path; 0 is the paper
        double feedback;      // f, share of the error that the state takes over; 0 is the paper
        double corner_rad_s;  // D/T, for ρ
        double rho_max;       // 0 is the paper
        double rho_speed_min; // rad/s; below it ρ = 0
    };

    explicit NnObserver(const Params &params) : p_(params)
    {
        state_ = {flux_current(), 0.0};
    }

    // φ/L_d, A.
    double flux_current() const
    {
        return p_.flux_wb / p_.inductance_d_h;
    }

    // What a vector at rest does in a frame that turns by ω·T·share.
    Eigen::Matrix2d rotation(double speed_rad_s, double share) const
    {
        return Eigen::Rotation2Dd(-speed_rad_s * p_.period_s * share).toRotationMatrix();
    }

    // T·R/L, the decay of both states in a period.
    Eigen::Matrix2d decay() const
    {
        return Vector(p_.period_s * p_.resistance_ohm / p_.inductance_d_h,
                      p_.period_s * p_.resistance_ohm / p_.inductance_q_h)
            .asDiagonal();
    }

    // D, the decay of an error: f acts on currents, and i_q = ŷ·L_d/L_q.
    Eigen::Matrix2d error_decay() const
    {
        const Vector of_state(p_.feedback, p_.feedback * p_.inductance_d_h / p_.inductance_q_h);
        return decay() + Eigen::Matrix2d(of_state.asDiagonal());
    }

    // (14)–(16) as ẑ(k) = W·ẑ(k−1) + W3·v + f·i, the weights at speed ω: the state turned through
    // −ω·T, what decays is taken in the middle of the turn, and there act v and the measured
    // current.
    Eigen::Matrix2d weights(double speed_rad_s) const
    {
        return rotation(speed_rad_s, 1.0) - rotation(speed_rad_s, 0.5) * error_decay();
    }

    // The same as printed: W1 = 1 − T/τ, W2 = −T·ω.
    Eigen::Matrix2d paper_weights(double speed_rad_s) const
    {
        const double w2 = -p_.period_s * speed_rad_s;
        Eigen::Matrix2d turn;
        turn << 0.0, -w2, w2, 0.0;
        return Eigen::Matrix2d::Identity() - decay() + turn;
    }

    // T·(v_x, v_y) of (8).
    Vector drive(const Vector &voltage_v) const
    {
        return p_.period_s * (voltage_v + Vector(p_.resistance_ohm * flux_current(), 0.0)) /
               p_.inductance_d_h;
    }

    // What resistance and voltage change of a state in a period, in the frame at its middle.
    Vector change(const Vector &state, const Vector &voltage_v) const
    {
        return drive(voltage_v) - decay() * state;
    }

    // T·R/L_d·î − f·e: what a period takes from a state's current, given the error of that instant.
    Vector drop(const Vector &state, const Vector &error) const
    {
        return decay()(0, 0) * current(state) - p_.feedback * error;
    }

    // The network's next state from any other and its error, and as printed.
    Vector predicted(const Vector &state, const Vector &error, const Vector &voltage_v,
                     double speed_rad_s) const
    {
        return rotation(speed_rad_s, 1.0) * state +
               rotation(speed_rad_s, 0.5) * (change(state, voltage_v) + p_.feedback * error);
    }
    Vector paper_predicted(const Vector &state, const Vector &voltage_v, double speed_rad_s) const
    {
        return paper_weights(speed_rad_s) * state + drive(voltage_v);
    }

    // One tick: currents in A and the voltage of the last interval in V, both in the estimated
    // frame.
    void step(const Vector &current_a, const Vector &voltage_v)
    {
        const Vector before = state_;

        state_ = predicted(before, error_, voltage_v, speed_out_);
        error_ = current_a - current();
        const double flux_error_q = p_.saliency * error_.y();
        rotated_error_ = {error_.x() + rho_ * flux_error_q, flux_error_q - rho_ * error_.x()};
        train(rotated_error_.y() * before.x() - rotated_error_.x() * before.y());
    }

    // (19)–(22) along a gradient b, A²: what step() does last.
    void train(double gradient)
    {
        weight_change_ = p_.eta * gradient + p_.alpha * weight_change_; // (19)–(21)
        speed_ -= weight_change_ / p_.period_s;                         // (22)
        speed_out_ =
            speed_ - p_.kappa_p / p_.period_s * gradient / (flux_current() * flux_current());
    }

    // ρ = D/(ω·T), limited; nothing at low speed.
    double rho_at(double speed_rad_s) const
    {
        const bool slow = std::abs(speed_rad_s) < p_.rho_speed_min;
        return slow ? 0.0 : std::clamp(p_.corner_rad_s / speed_rad_s, -p_.rho_max, p_.rho_max);
    }

    void set_rho(double rho)
    {
        rho_ = rho;
    }

    // î_d, î_q: the shift of (7) and the scale of y undone.
    Vector current(const Vector &state) const
    {
        return {state.x() - flux_current(), state.y() * p_.inductance_d_h / p_.inductance_q_h};
    }
    Vector current() const
    {
        return current(state_);
    }

    const Vector &error() const
    {
        return error_;
    }

    // e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q)
    const Vector &rotated_error() const
    {
        return rotated_error_;
    }

    // x̂ = i_d + φ/L_d, ŷ = (L_q/L_d)·i_q.
    const Vector &state() const
    {
        return state_;
    }

    // ω̂, the integral (22), rad/s electrical.
    double speed() const
    {
        return speed_;
    }

    // ω̂ with the proportional path: inside the network and for the angle.
    double speed_out() const
    {
        return speed_out_;
    }

    // weight_change: ΔW2 of the last tick, for the momentum.
    void set(const Vector &state, double speed_rad_s, double speed_out_rad_s,
             double weight_change = 0)
    {
        state_ = state;
        speed_ = speed_rad_s;
        speed_out_ = speed_out_rad_s;
        weight_change_ = weight_change;
    }

    // Of the last tick, for the feedback.
    void set_error(const Vector &error)
    {
        error_ = error;
    }

private:
    Params p_;
    Vector state_;
    Vector error_ = Vector::Zero();
    Vector rotated_error_ = Vector::Zero();
    double rho_ = 0;
    double weight_change_ = 0;
    double speed_ = 0;
    double speed_out_ = 0;
};

} // namespace nf::twin
