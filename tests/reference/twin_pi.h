// PI controller, paper B (28)–(30), backward difference, with limited output and integral.
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
        const double moved = std::clamp(integral_ + params_.ki_t * error, -limit, limit);
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
    void unwind(double excess, double limit)
    {
        integral_ = std::clamp(integral_ - excess, -limit, limit);
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
    Params params_;
    double integral_ = 0;
    bool frozen_ = false;
};

} // namespace nf::twin
