// SPDX-License-Identifier: MIT
#include "flying_start_units.h"

#include "imposed_current.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// A pulse that looks for a turning rotor ends at this share of the largest current.
constexpr double FLYING_START_SHARE = 0.05;
constexpr double FLYING_START_LSB = 25; // or so many counts: 4 % of noise, 2°

// Open gates put the bus against a current, which ends in L·I/U: ten times what 100 mH, 30 A and
// 300 V take.
constexpr double FLYING_START_WAIT_S = 0.1;
constexpr int FLYING_START_TICKS = 8;
constexpr double FLYING_START_GAP_MAX = 64;

// Turns between the ends of two pulses: below a half is unique, at the highest speed with the
// shortest pulse …
constexpr double FLYING_START_TURN_MAX = 0.4;

// … and in general, where a pulse may be twice as long as needed, and L/φ 1.4 times that of the
// file. Device drop and noise turn a direction by some 4°, so that the turn must not be much
// smaller either.
constexpr double FLYING_START_TURN = 0.15;

// In the pause the speed must not change much: a tenth of the highest one at the rated torque.
constexpr double FLYING_START_CHANGE = 0.1;
constexpr double FLYING_START_PAUSE_MIN = 32;
constexpr double FLYING_START_PAUSE_MAX = 256;

double flying_start_current(const MotorSettings &motor, const BoardSettings &board)
{
    return std::max(FLYING_START_SHARE * motor.max_current_a, FLYING_START_LSB * count_a(board));
}

// In lengths of a pulse, in which the rotor turns by I·L_q/φ.
double flying_start_gap(const MotorSettings &motor, const BoardSettings &board, const Model &m,
                        const Bases &b)
{
    const double fastest = m.max_speed_el * b.control_period_s / TWO_PI;
    const double pulse = flying_start_current(motor, board) * m.inductance_q / m.flux / TWO_PI;
    const double most = std::min(FLYING_START_TURN_MAX / fastest, FLYING_START_TURN / pulse) - 1;
    return std::clamp(std::floor(most), 1.0, FLYING_START_GAP_MAX);
}

double flying_start_pause_max(const MotorSettings &motor, const Model &m, const Bases &b)
{
    const double speeding_up = m.max_speed_el / (m.torque_acceleration * rated_current(motor));
    return std::clamp(std::floor(FLYING_START_CHANGE * speeding_up / b.control_period_s),
                      FLYING_START_PAUSE_MIN, FLYING_START_PAUSE_MAX);
}

} // namespace

flying_start_cfg_t make_flying_start(const MotorSettings &motor, const BoardSettings &board,
                                     const Model &m, const Bases &b)
{
    flying_start_cfg_t c{};
    store(c.current, flying_start_current(motor, board) / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, CURRENT_REASON);
    c.wait_ticks = ticks(FLYING_START_WAIT_S, b);
    c.pulse_ticks = FLYING_START_TICKS;
    c.gap_factor = static_cast<uint32_t>(flying_start_gap(motor, board, m, b));
    c.pause_max = static_cast<uint32_t>(flying_start_pause_max(motor, m, b));
    // The EMF lies along q. What R takes in a tick: a = T·R/L_q.
    const double a = b.control_period_s * m.resistance / m.inductance_q;
    const double left = -std::expm1(-a) / a;
    const double per_step =
        TWO_PI / STEPS_PER_TURN * m.flux / m.inductance_q * left / b.current_a * Q15;
    const Mantissa emf =
        normalise(std::ldexp(per_step, 16), 0, 30, {"motor.flux_linkage_wb", motor.flux_linkage_wb},
                  CURRENT_REASON);
    c.emf_current = emf.value;
    c.emf_shift = emf.shift;
    keep(c.decay_q15, -std::expm1(-a) * Q15, 0, MANTISSA_MAX);
    c.charge_ticks = board.bootstrap_charge_s > 0 ? ticks(board.bootstrap_charge_s, b) : 0;
    return c;
}

double flying_start_time_s(const MotorSettings &motor, const Model &m, const Bases &b)
{
    const double pause = flying_start_pause_max(motor, m, b);
    return (2 * FLYING_START_TICKS + pause + 2) * b.control_period_s;
}

} // namespace nf
