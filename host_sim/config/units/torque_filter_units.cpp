// SPDX-License-Identifier: MIT
#include "torque_filter_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// From here on a turn in a sample is more than what its sine and cosine are rounded by: the
// frequency is right within 0.1 %, and so is the gain at rest.
constexpr double LEAST_SHARE = 1.0 / 256;

// r: the low-pass of a continuous one, sampled.
double smooth_rate(const TuningSettings &tuning, double rate_hz)
{
    return 1 - std::exp(-TWO_PI * tuning.torque_filter_hz / rate_hz);
}

// μ. With a quarter of the rate it is 1, and the notch knows one sample only: the band is not
// wider.
double notch_share(const TuningSettings &tuning, double rate_hz)
{
    const double band_hz = std::min(tuning.notch_hz * tuning.notch_width_pct / 100, rate_hz / 4);
    const double t = std::tan(PI * band_hz / rate_hz);
    return 2 * t / (1 + t);
}

// θ, rad.
double notch_turn(const TuningSettings &tuning, double rate_hz)
{
    return TWO_PI * tuning.notch_hz / rate_hz;
}

// A filter sees frequencies up to half of its rate.
void check_frequency(const Source &frequency, double rate_hz)
{
    require(frequency, rate_hz * LEAST_SHARE, rate_hz / 2,
            "1/256 to 1/2 of the rate of the speed loop, which is board.pwm_frequency_hz over "
            "speed_loop.slow_ticks");
}

void set_low_pass(torque_filter_cfg_t &c, const TuningSettings &tuning, double rate_hz)
{
    check_frequency({"speed_loop.torque_filter_hz", tuning.torque_filter_hz}, rate_hz);
    keep(c.smooth_rate_q15, smooth_rate(tuning, rate_hz) * Q15, 1, MANTISSA_MAX);
}

void set_notch(torque_filter_cfg_t &c, const TuningSettings &tuning, double rate_hz)
{
    check_frequency({"speed_loop.notch_hz", tuning.notch_hz}, rate_hz);
    keep(c.notch_share_q15, notch_share(tuning, rate_hz) * Q15, 1, MANTISSA_MAX);
    const double turn = notch_turn(tuning, rate_hz);
    keep(c.notch_turn.sin, std::sin(turn) * Q15, -MANTISSA_MAX, MANTISSA_MAX);
    keep(c.notch_turn.cos, std::cos(turn) * Q15, -MANTISSA_MAX, MANTISSA_MAX);
}

} // namespace

bool has_torque_filter(const TuningSettings &tuning)
{
    return tuning.notch_hz > 0 || tuning.torque_filter_hz > 0;
}

double speed_loop_rate(const TuningSettings &tuning, double control_period_s)
{
    return 1 / (control_period_s * tuning.slow_ticks);
}

torque_filter_cfg_t make_torque_filter(const TuningSettings &tuning, const Bases &b)
{
    const double rate_hz = speed_loop_rate(tuning, b.control_period_s);
    torque_filter_cfg_t c{};
    if (tuning.torque_filter_hz > 0) {
        set_low_pass(c, tuning, rate_hz);
    }
    if (tuning.notch_hz > 0) {
        set_notch(c, tuning, rate_hz);
    }
    return c;
}

std::complex<double> torque_filter_response(const TuningSettings &tuning, double rate_hz, double hz)
{
    const std::complex<double> later = std::polar(1.0, -TWO_PI * hz / rate_hz); // z⁻¹
    std::complex<double> response = 1;
    if (tuning.torque_filter_hz > 0) {
        const double r = smooth_rate(tuning, rate_hz);
        response *= r / (1.0 - (1 - r) * later);
    }
    if (tuning.notch_hz > 0) {
        const double mu = notch_share(tuning, rate_hz);
        const double cosine = std::cos(notch_turn(tuning, rate_hz));
        response *= (1 - mu / 2) * (1.0 - 2 * cosine * later + later * later) /
                    (1.0 - (2 - mu) * cosine * later + (1 - mu) * later * later);
    }
    return response;
}

} // namespace nf
