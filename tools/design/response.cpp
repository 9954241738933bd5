// SPDX-License-Identifier: MIT
#include "response.h"

#include <algorithm>
#include <cmath>

namespace nf::design
{

Response step_response(const Discrete &motor, const Gains &gains, double k2, int input,
                       double duration_s)
{
    const PhaseLoop loop = add_phase_states(motor, gains, k2);
    const double command = input == SUPPLY ? 1 : 0;
    const auto samples = static_cast<int>(std::lround(duration_s / motor.sample_time_s));
    Response response;
    PhaseVector state = PhaseVector::Zero();
    for (int n = 0; n <= samples; n++) {
        response.time_s.push_back(n * motor.sample_time_s);
        response.states.push_back(state);
        response.output_rad_s.push_back(
            controller_output(motor, gains, state.head<STATE_COUNT>(), command));
        state = (loop.a * state + loop.b.col(input)).eval();
    }
    return response;
}

LoopState settled(const Discrete &motor, const Gains &gains, int input)
{
    const Loop loop = close_loop(motor, gains);
    return (LoopMatrix::Identity() - loop.a).partialPivLu().solve(loop.b.col(input));
}

ResponseFigures figures(const Discrete &motor, const Gains &gains, int input,
                        const Response &response)
{
    const double target = input == SUPPLY ? 1 : 0;
    ResponseFigures f{};
    double sum = 0;
    for (std::size_t n = 0; n < response.states.size(); n++) {
        const double off = response.states[n][SPEED] - target;
        sum += off * off;
        f.overshoot_rad_s = std::max(f.overshoot_rad_s, off);
        if (n > 0 && std::abs(off) > std::abs(f.peak_rad_s)) {
            f.peak_rad_s = off;
            f.peak_time_s = response.time_s[n];
        }
    }
    f.rms_rad_s = std::sqrt(sum / static_cast<double>(response.states.size()));
    for (const std::complex<double> &pole : poles(close_loop(motor, gains).a)) {
        const double time_s = time_constant_s(std::abs(pole), motor.sample_time_s);
        f.slowest_s = std::max(f.slowest_s, time_s);
        if (pole.imag() != 0) {
            f.envelope_s = std::max(f.envelope_s, time_s);
        }
    }
    return f;
}

} // namespace nf::design
