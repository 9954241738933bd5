// SPDX-License-Identifier: MIT
#include "turning.h"

#include <cmath>

namespace nf::identify
{
namespace
{

double sinc(double x)
{
    return std::abs(x) > 0 ? std::sin(x) / x : 1;
}

} // namespace

std::complex<double> emf_of(const Window &window, const LegModel &legs, double period_s)
{
    const std::complex<double> i = window.current_a;
    const double size_a = std::abs(i);
    const double loss_v = size_a > 0 ? loss_turning(legs, size_a) / size_a : 0;
    return window.voltage_v * sinc(window.speed_rad_s * period_s / 2) -
           (legs.resistance_ohm + loss_v) * i;
}

double magnet_of(const Window &window, const LegModel &legs, const Inductances &inductances,
                 double period_s)
{
    const std::complex<double> j(0, 1);
    const double speed = window.speed_rad_s;
    const double lq_h = inductances.q_h.value;
    const std::complex<double> e = emf_of(window, legs, period_s) - j * speed * lq_h * window.current_a;
    const std::complex<double> turn = std::polar(1.0, -std::arg(e / (j * speed)));
    const double along_a = (window.current_a * turn).real();
    return std::abs(e / speed) - inductances.flux_d(along_a) + lq_h * along_a;
}

double torque_of(const Window &window, const LegModel &legs, const Scales &scales)
{
    const std::complex<double> e = emf_of(window, legs, scales.period_s);
    return 1.5 * scales.pole_pairs * (e * std::conj(window.current_a)).real() / window.speed_rad_s;
}

} // namespace nf::identify
