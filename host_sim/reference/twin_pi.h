/* SPDX-License-Identifier: MIT */
// PI controller, paper B (28)–(30), backward difference, with limited output; the integral
// saturates at ±1 per unit.
#pragma once

#include <algorithm>

namespace nf::twin
{

class Pi
{
public:
    struct Params {
        double kp;   // output unit per error unit
        double ki_t; // integral gain times the period, same unit
        double one;  // of the output, in its unit
    };

    explicit Pi(const Params &params) : params_(params)
    {
    }

    void reset(double output)
    {
        integral_ = output;
    }

    // One sample; the result is within ±limit.
    double step(double error, double feed_forward, double limit)
    {
        const double moved = saturated(integral_ + params_.ki_t * error);
        const double wanted = params_.kp * error + moved + feed_forward;
        const bool too_high = wanted > limit;
        const bool too_low = wanted < -limit;
        // Anti-windup: at a limit the integral may only come back from it.
        frozen_ = (too_high && moved > integral_) || (too_low && moved < integral_);
        if (!frozen_) {
            integral_ = moved;
        }
        return std::clamp(wanted, -limit, limit);
    }

    // Of the last output only output − excess could be used.
    void unwind(double excess)
    {
        integral_ = saturated(integral_ - excess);
    }

    double integral() const
    {
        return integral_;
    }

    // The last step left the integral as it was because of a limit.
    bool frozen() const
    {
        return frozen_;
    }

private:
    double saturated(double integral) const
    {
        return std::clamp(integral, -params_.one, params_.one);
    }

    Params params_;
    double integral_ = 0;
    bool frozen_ = false;
};

} // namespace nf::twin
