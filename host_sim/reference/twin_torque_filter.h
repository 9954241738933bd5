/* SPDX-License-Identifier: MIT */
// Low-pass and notch of the torque current, in amperes.
#pragma once

#include <complex>

namespace nf::twin
{

class TorqueFilter
{
public:
    struct Params {
        double smooth_rate; // r, 0: no low-pass
        double notch_share; // μ, 0: no notch
        std::complex<double> notch_turn;
    };

    explicit TorqueFilter(const Params &params) : params_(params)
    {
    }

    void start(double current)
    {
        set(current, current, 0);
    }

    void set(double origin, double smooth, std::complex<double> swing)
    {
        origin_ = origin;
        smooth_ = smooth;
        swing_ = swing;
    }

    // One sample: the filtered current.
    double step(double current)
    {
        double passed = current;
        if (params_.smooth_rate > 0) {
            smooth_ += params_.smooth_rate * (current - smooth_);
            passed = smooth_;
        }
        if (params_.notch_share > 0) {
            const double rest = passed - origin_ - swing_.real();
            swing_ = params_.notch_turn * (swing_ + params_.notch_share * rest);
            passed = origin_ + (1 - params_.notch_share / 2) * rest;
        }
        return passed;
    }

    double smooth() const
    {
        return smooth_;
    }

    std::complex<double> swing() const
    {
        return swing_;
    }

private:
    Params params_;
    double origin_ = 0;
    double smooth_ = 0;
    std::complex<double> swing_;
};

} // namespace nf::twin
