/* SPDX-License-Identifier: MIT */
// An estimator of angle and speed that can take the place of the drive's own observer, in double
// precision and SI units.
//
// What it is told is what the drive's observer is told: currents and voltages as sampled, and the
// motor model in force, with R and L as measured and φ as tracked. All vectors are complex numbers
// in the stationary frame, α + jβ; angles and speeds are electrical.
#pragma once

#include <complex>

namespace nf::peers
{

using Complex = std::complex<double>;

constexpr Complex J(0.0, 1.0);

// What the drive takes the motor for.
struct Model {
    double period_s;
    double resistance_ohm;
    double inductance_d_h;
    double inductance_q_h;
    double flux_wb;
    double speed_min_rad_s;   // below it the EMF is too small to show an angle
    double speed_limit_rad_s; // of the estimate
};

// At an instant.
struct Sample {
    Complex current_a;
    Complex voltage_v; // mean since the last instant
    // A speed whose sign can be trusted: the reference's at low speed, where the estimate may
    // swing.
    double course_rad_s;
};

struct Estimate {
    double angle_rad;
    double speed_rad_s;
};

class Estimator
{
public:
    Estimator() = default;
    Estimator(const Estimator &) = delete;
    Estimator &operator=(const Estimator &) = delete;
    virtual ~Estimator() = default;

    // Begins with what is known of the next instant, and the current of this one.
    virtual void start(const Model &model, const Estimate &known, Complex current_a) = 0;
    // One period later: the estimate for the next instant.
    virtual Estimate step(const Model &model, const Sample &sample) = 0;
    // Of the next instant this is known: the rotor is led by an imposed current.
    virtual void follow(const Model &model, const Estimate &known) = 0;
};

// e^{jx}
inline Complex turn(double angle_rad)
{
    return std::polar(1.0, angle_rad);
}

} // namespace nf::peers
