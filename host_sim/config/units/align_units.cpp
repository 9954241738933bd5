// SPDX-License-Identifier: MIT
#include "align_units.h"

#include "hold_loop_units.h"
#include "imposed_current.h"
#include "inductance_units.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Times of the alignment in units of 1/ω_n, the rotor's swing in the field of the imposed current.
// Half a turn of the vector in 8 leaves no starting angle from which the rotor swings back by half
// a turn under 40 % of rated torque (measured over 64 angles; 5 does); after three times as long a
// swing damped with 0.3 has gone down to 1/1000.
constexpr double SWEEP = 8;
constexpr double PULL = 24;
constexpr double SETTLE = 6;
constexpr double MEASURE = 4;

// The second level of the current: well apart from the first, and still enough to hold a load.
constexpr double LOW_SHARE = 0.62;

// A rotor rests while the current across stays below the smaller of two limits. One is the share
// from which on a rotor slips. The other is what the EMF at this share of the hand-over speed
// drives, but at least so many counts: noise of 1.5 counts reaches 4.5 times that in 2^16 samples
// of a winding, and nearly twice as much across.
constexpr double REST_SHARE = 1.0 / ALIGN_SLIP_SHARE;
constexpr double REST_SPEED = 0.125;
constexpr double REST_LSB = 12;

// The current across swings by this share of the imposed one. From 1/√3 on, a phase with half of it
// against it passes through zero; so an L_q of 0.6 of the file's is still measured without dead
// time.
constexpr double PULSE_SHARE = 0.3;

uint32_t measure_log2(double swing, const Bases &b)
{
    const double wanted = MEASURE / swing / b.control_period_s;
    return static_cast<uint32_t>(std::clamp(std::ceil(std::log2(wanted)), 6.0, 16.0));
}

// Half a turn of the vector: in the rotor's own time, and not faster than the drive may turn.
double sweep_time_s(double swing, const Bases &b)
{
    return std::max(SWEEP / swing, STEPS_PER_TURN / 2 / b.speed_limit * b.control_period_s);
}

// The hold's, unless it is written; within the same limits.
double align_current(const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning)
{
    TuningSettings aligning = tuning;
    if (tuning.align_current_pct > 0) {
        aligning.startup_current_pct = tuning.align_current_pct;
    }
    return hold_current(motor, board, aligning);
}

// What may flow across the vector while the rotor rests. A rotor that slips drives its EMF over R
// and K_p: where R·I is many times that EMF, it is a small part of the current. A current of less
// than 60 counts does not tell a slip from noise.
double resting_swing(double current_a, const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning, const ModelScales &scales, const Model &m)
{
    const double emf_v = REST_SPEED * handover_rad_s(motor, tuning) * m.flux;
    const double slips_a = emf_v / (m.resistance + hold_gain_ohm(motor, board, tuning, scales, m));
    return std::min(REST_SHARE * current_a, std::max(slips_a, REST_LSB * count_a(board)));
}

} // namespace

align_cfg_t make_align(const MotorSettings &motor, const BoardSettings &board,
                       const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                       const Bases &b)
{
    const double current = align_current(motor, board, tuning);
    const double swing = swing_rad_s(motor, board, tuning, m);
    align_cfg_t c{};
    const Source written = {"startup.align_current_pct", tuning.align_current_pct};
    store(c.current_high, current / b.current_a * Q15, tuning.align_current_pct > 0 ? HOLD_MIN : 0,
          Q14, written, CURRENT_REASON);
    c.current_low = current_q15(current * LOW_SHARE, b);
    keep(c.swing_max, resting_swing(current, motor, board, tuning, scales, m) / b.current_a * Q15,
         1, Q14);
    c.slope = hold_slope(motor, board, tuning, m, b);
    c.sweep_ticks = ticks(sweep_time_s(swing, b), b);
    keep(c.sweep_speed, STEPS_PER_TURN / 2 / c.sweep_ticks, 1, b.speed_limit);
    c.pull_ticks = std::max(c.sweep_ticks, ticks(align_pull_time_s(swing, b), b));
    c.settle_ticks = ticks(align_settle_time_s(swing), b);
    c.measure_log2 = measure_log2(swing, b);
    c.inductance = make_inductance(current * (1 - LOW_SHARE), current * PULSE_SHARE, board, m, b);
    return c;
}

double align_pull_time_s(double swing, const Bases &b)
{
    return sweep_time_s(swing, b) * (PULL / SWEEP);
}

double align_settle_time_s(double swing)
{
    return SETTLE / swing;
}

double align_measure_time_s(double swing, const Bases &b)
{
    return 2 * std::exp2(measure_log2(swing, b)) * b.control_period_s;
}

} // namespace nf
