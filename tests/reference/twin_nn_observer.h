// Neural-network speed observer, paper A (14)–(22), in SI units and without any limit.
#pragma once

#include "twin_transforms.h"

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
        double flux_wb;
        double eta;     // learning rate of (19)
        double alpha;   // momentum of (19)
        double kappa_p; // proportional path; 0 is the paper
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

    // (14)–(16) as ẑ(k) = W·ẑ(k−1) + W3·v, the weights at speed ω.
    Eigen::Matrix2d weights(double speed_rad_s) const
    {
        const double w1_d = 1.0 - p_.period_s * p_.resistance_ohm / p_.inductance_d_h;
        const double w1_q = 1.0 - p_.period_s * p_.resistance_ohm / p_.inductance_q_h;
        const double w2 = -p_.period_s * speed_rad_s;
        Eigen::Matrix2d w;
        w << w1_d, -w2, w2, w1_q;
        return w;
    }

    // One tick: currents in A and the voltage of the last interval in V, both in the estimated frame.
    void step(const Vector &current_a, const Vector &voltage_v)
    {
        const Vector before = state_;
        const Vector drive =
            (voltage_v + Vector(p_.resistance_ohm * flux_current(), 0.0)) / p_.inductance_d_h;

        state_ = weights(speed_out_) * before + p_.period_s * drive;
        error_ = current_a - current();
        train(error_.y() * before.x() - error_.x() * before.y());
    }

    // î_d, î_q: the shift of (7) and the scale of y undone.
    Vector current() const
    {
        return {state_.x() - flux_current(), state_.y() * p_.inductance_d_h / p_.inductance_q_h};
    }

    const Vector &error() const
    {
        return error_;
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

    void set(const Vector &state, double speed_rad_s, double speed_out_rad_s)
    {
        state_ = state;
        speed_ = speed_rad_s;
        speed_out_ = speed_out_rad_s;
        weight_change_ = 0;
    }

private:
    void train(double descent)
    {
        weight_change_ = p_.eta * descent + p_.alpha * weight_change_; // (19)–(21)
        speed_ -= weight_change_ / p_.period_s;                        // (22)
        speed_out_ =
            speed_ - p_.kappa_p / p_.period_s * descent / (flux_current() * flux_current());
    }

    Params p_;
    Vector state_;
    Vector error_ = Vector::Zero();
    double weight_change_ = 0;
    double speed_ = 0;
    double speed_out_ = 0;
};

} // namespace nf::twin
