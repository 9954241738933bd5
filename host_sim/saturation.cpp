#include "saturation.h"

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
    "network_x",
    "network_y",
    "network_error_d",
    "network_error_q",
    "network_weight_step",
    "network_speed",
    "network_speed_out",
    "reactance_d",
    "reactance_q",
    "emf",
    "speed_error",
    "position_lag",
    "torque",
    "voltage",
    "ratio",
    "duty",
};

// The clamps of drive.c, nn_observer.c, current_loop.c and motion_loop.c.
constexpr int32_t PHASE_LIMIT = 16383;
constexpr int32_t STATE_LIMIT_Q27 = (1 << 27) - 1;
constexpr int32_t ERROR_LIMIT = 8191;
constexpr int32_t WEIGHT_STEP_LIMIT = 1 << 29;
constexpr int32_t RECIPROCAL_MIN_Q12 = 1 << 12;
constexpr unsigned REACTANCE_BITS = 13;
constexpr unsigned LAG_BITS = 16;

// One bit a signal that is at the end of its range.
using Mask = uint32_t;
static_assert(SIGNAL_COUNT <= 32);

constexpr Mask bit(Signal signal, bool set)
{
    return static_cast<Mask>(set) << static_cast<unsigned>(signal);
}

bool at(int32_t x, int32_t limit)
{
    return std::abs(x) >= limit;
}

Mask measured(const drive_t &drive)
{
    const drive_signals_t &s = drive.signals;
    const int32_t reciprocal = drive.modulator.inverse_bus_q12;
    return bit(Signal::phase_a, at(s.phase_a, PHASE_LIMIT)) |
           bit(Signal::phase_b, at(s.phase_b, PHASE_LIMIT)) |
           bit(Signal::bus, at(s.bus, FX_Q15_MAX)) |
           bit(Signal::bus_reciprocal, reciprocal <= RECIPROCAL_MIN_Q12 ||
                                           reciprocal >= drive.cfg->modulator.inverse_max_q12);
}

Mask network(const nn_observer_t &n, const nn_observer_cfg_t &cfg)
{
    return bit(Signal::network_x, at(n.x_q27, STATE_LIMIT_Q27)) |
           bit(Signal::network_y, at(n.y_q27, STATE_LIMIT_Q27)) |
           bit(Signal::network_error_d, at(n.error.d, ERROR_LIMIT)) |
           bit(Signal::network_error_q, at(n.error.q, ERROR_LIMIT)) |
           bit(Signal::network_weight_step, at(n.weight_step, WEIGHT_STEP_LIMIT)) |
           bit(Signal::network_speed, at(n.speed, cfg.speed_limit)) |
           bit(Signal::network_speed_out, at(n.speed_out, cfg.speed_limit));
}

bool gain_ends(int32_t speed, int32_t gain)
{
    return at((speed * gain) >> REACTANCE_BITS, FX_Q15_MAX);
}

Mask loops(const drive_t &drive)
{
    const current_loop_cfg_t &current = drive.cfg->current_loop;
    const int32_t speed = drive.signals.speed;
    const int32_t error =
        (drive.speed_loop.reference - drive.observer.speed) >> drive.cfg->speed_loop.error_shift;
    const int64_t lag = (drive.position_loop.profile_q32 - drive.position.turns_q32) >> LAG_BITS;
    const bool positioning = drive.mode == DRIVE_MODE_POSITION;
    return bit(Signal::reactance_d, gain_ends(speed, current.reactance_d_q13)) |
           bit(Signal::reactance_q, gain_ends(speed, current.reactance_q_q13)) |
           bit(Signal::emf, gain_ends(speed, current.emf_q13)) |
           bit(Signal::speed_error, at(error, FX_Q15_MAX)) |
           bit(Signal::position_lag, positioning && std::abs(lag) >= FX_Q15_MAX);
}

// v_q is cut to the root, rounded down, of what v_d leaves of the circle.
bool on_circle(const drive_signals_t &s)
{
    const int32_t q = std::abs(s.voltage.q) + 1;
    return s.voltage.d * s.voltage.d + q * q > s.voltage_limit * s.voltage_limit;
}

bool duty_ends(const compare_t &compare, int32_t counts)
{
    bool ends = false;
    for (const uint16_t value : compare.phase) {
        ends |= value == 0 || value == counts;
    }
    return ends;
}

Mask limits(const drive_t &drive, const drive_out_t &out)
{
    const drive_signals_t &s = drive.signals;
    const modulator_cfg_t &modulator = drive.cfg->modulator;
    return bit(Signal::torque, at(s.current_ref_q, drive.cfg->speed_loop.current_max)) |
           bit(Signal::voltage, on_circle(s)) |
           bit(Signal::ratio,
               at(s.ratio.d, modulator.ratio_max_q15) || at(s.ratio.q, modulator.ratio_max_q15)) |
           bit(Signal::duty, duty_ends(out.compare, modulator.timer_counts));
}

} // namespace

const char *signal_name(std::size_t signal)
{
    return NAMES.at(signal);
}

void Saturations::add(const drive_t &drive, const drive_out_t &out)
{
    Mask mask = measured(drive) | network(drive.observer, drive.cfg->observer) | loops(drive) |
                limits(drive, out);
    for (std::size_t k = 0; mask != 0; k++, mask >>= 1U) {
        ticks_[k] += mask & 1U;
    }
}

uint64_t Saturations::internal_count() const
{
    return std::accumulate(ticks_.begin(), ticks_.begin() + FIRST_LIMIT, uint64_t{0});
}

} // namespace nf
