// SPDX-License-Identifier: MIT
#include "saturation.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace nf
{
namespace
{

constexpr std::array<const char *, SIGNAL_COUNT> NAMES = {
    "phase_a",
    "phase_b",
    "bus",
    "bus_reciprocal",
    "network_alpha",
    "network_beta",
    "network_error_d",
    "network_error_q",
    "network_weight_step",
    "network_speed",
    "integral_d",
    "integral_q",
    "integral_speed",
    "speed_error",
    "position_lag",
    "torque",
    "voltage",
    "ratio",
    "duty",
};

// The clamps of tick.c, nn_observer.c, pi.c and motion_loop.c.
constexpr int32_t PHASE_LIMIT = 16383;
constexpr int32_t STATE_LIMIT_Q27 = (1 << 27) - 1;
constexpr int32_t ERROR_LIMIT = 8191;
constexpr int32_t WEIGHT_STEP_LIMIT = (1 << 29) - 1;
constexpr int32_t RECIPROCAL_MIN_Q12 = 1 << 12;
constexpr int32_t INTEGRAL_LIMIT_Q26 = (1 << 26) - 1;
constexpr unsigned LAG_BITS = 16;

// |x| >= limit, limit > 0, as one comparison.
bool at(int32_t x, int32_t limit)
{
    const uint32_t inside = static_cast<uint32_t>(limit) - 1U;
    return static_cast<uint32_t>(x) + inside > 2U * inside;
}

// Each check calls note(signal, whether it is at the end of its range).
template <typename Note>
void check_measured(const drive_t &drive, const sample_t &sample, Note note)
{
    const int32_t reciprocal = drive.modulator.inverse_bus_q12;
    note(Signal::phase_a, at(sample.phase_a, PHASE_LIMIT));
    note(Signal::phase_b, at(sample.phase_b, PHASE_LIMIT));
    note(Signal::bus, sample.bus >= FX_Q15_MAX);
    note(Signal::bus_reciprocal,
         reciprocal <= RECIPROCAL_MIN_Q12 || reciprocal >= MODULATOR_INVERSE_MAX_Q12);
}

template <typename Note> void check_network(const drive_t &drive, Note note)
{
    const nn_observer_t &n = drive.rotor.observer;
    const step_t speed_limit = drive.cfg->observer.speed_limit;
    note(Signal::network_alpha, at(n.alpha_q27, STATE_LIMIT_Q27));
    note(Signal::network_beta, at(n.beta_q27, STATE_LIMIT_Q27));
    note(Signal::network_error_d, at(n.error.d, ERROR_LIMIT));
    note(Signal::network_error_q, at(n.error.q, ERROR_LIMIT));
    note(Signal::network_weight_step, at(n.weight_step, WEIGHT_STEP_LIMIT));
    note(Signal::network_speed, at(n.speed, speed_limit));
}

template <typename Note> void check_loops(const drive_t &drive, Note note)
{
    const int32_t error = (drive.motion.speed_loop.reference - drive.rotor.observer.speed) >>
                          drive.cfg->speed_loop.error_shift;
    const current_loop_t &loop = drive.control.current_loop;
    note(Signal::integral_d, at(loop.pi_d.integral_q26, INTEGRAL_LIMIT_Q26));
    note(Signal::integral_q, at(loop.pi_q.integral_q26, INTEGRAL_LIMIT_Q26));
    note(Signal::integral_speed, at(drive.motion.speed_loop.pi.integral_q26, INTEGRAL_LIMIT_Q26));
    note(Signal::speed_error, at(error, FX_Q15_MAX));
    if (drive.motion.mode == DRIVE_MODE_POSITION) {
        const int64_t lag = drive.motion.position_loop.profile_q32 - drive.rotor.position.turns_q32;
        note(Signal::position_lag, std::abs(lag >> LAG_BITS) >= FX_Q15_MAX);
    }
}

// v_q is cut to the root, rounded down, of what v_d leaves of the circle.
bool on_circle(const dq_t &voltage, int32_t limit)
{
    const int32_t q = std::abs(voltage.q) + 1;
    return voltage.d * voltage.d + q * q > limit * limit;
}

template <typename Note> void check_limits(const drive_t &drive, const drive_out_t &out, Note note)
{
    const modulator_cfg_t &modulator = drive.cfg->modulator;
    const auto [lowest, highest] =
        std::minmax({out.compare.phase[0], out.compare.phase[1], out.compare.phase[2]});
    note(Signal::torque, drive_current_in_force(&drive).q >= drive.motion.torque_range.upper ||
                             drive_current_in_force(&drive).q <= drive.motion.torque_range.lower);
    note(Signal::voltage, on_circle(drive.control.voltage, modulator_limit(&modulator, drive.bus)));
    note(Signal::ratio, std::abs(drive.control.ratio_next.alpha) >= modulator.ratio_max_q15 ||
                            std::abs(drive.control.ratio_next.beta) >= modulator.ratio_max_q15);
    note(Signal::duty, lowest == 0 || highest >= modulator.timer_counts);
}

template <typename Note>
void check_all(const drive_t &drive, const sample_t &sample, const drive_out_t &out, Note note)
{
    check_measured(drive, sample, note);
    check_network(drive, note);
    check_loops(drive, note);
    check_limits(drive, out, note);
}

} // namespace

const char *signal_name(std::size_t signal)
{
    return NAMES.at(signal);
}

// Most ticks have nothing to count: that is found out first, without storing anything.
void Saturations::add(const drive_t &drive, const sample_t &sample, const drive_out_t &out)
{
    bool any = false;
    check_all(drive, sample, out, [&any](Signal, bool ends) { any |= ends; });
    if (any) {
        check_all(drive, sample, out, [this](Signal signal, bool ends) {
            ticks_[static_cast<std::size_t>(signal)] += ends ? 1U : 0U;
        });
    }
}

uint64_t Saturations::internal_count() const
{
    return std::accumulate(ticks_.begin(), ticks_.begin() + FIRST_LIMIT, uint64_t{0});
}

} // namespace nf
