// SPDX-License-Identifier: MIT
#include "current_reference_units.h"

#include "imposed_current.h"
#include "numbers.h"
#include "weakening_units.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The least current goes so many times more slowly than it comes. A voltage drive takes over
// without it, and does not wait.
constexpr int32_t CURRENT_FALL = 32;

// Of a salient machine the least current takes φ − (L_q − L_d)·i_d down. Where it takes more than
// this share of φ it goes as fast as a torque comes: the torque, and the estimate of the angle,
// have only the flux that is left.
constexpr double FLUX_TAKEN = 0.125;

// The magnets bear the i_d of the largest torque of the largest current: 4·ΔL·|i_d| = √(φ² +
// 8·ΔL²·I²) − φ.
void check_most_torque(const MotorSettings &motor)
{
    const double saliency = motor.inductance_q_h - motor.inductance_d_h;
    if (saliency <= 0 || !(motor.demagnetising_current_a > 0)) {
        return;
    }
    const double flux = motor.flux_linkage_wb;
    const double root = std::sqrt(flux * flux + 8 * std::pow(saliency * motor.max_current_a, 2));
    require((root - flux) / (4 * saliency), 0, motor.demagnetising_current_a,
            {"motor.max_current_a", motor.max_current_a},
            "above it the i_d of its largest torque is beyond motor.demagnetising_current_a; "
            "current_loop.most_torque = 0 leaves i_d at 0");
}

int32_t current_fall(int32_t slope, double least_a, const MotorSettings &motor,
                     const TuningSettings &tuning)
{
    if (tuning.method == ControlMethod::voltage_phase) {
        return slope;
    }
    if (1 - active_share(least_a, motor) > FLUX_TAKEN) {
        return static_cast<int32_t>(Q14);
    }
    return std::max(slope / CURRENT_FALL, 1);
}

} // namespace

current_reference_cfg_t make_current_reference(const MotorSettings &motor,
                                               const BoardSettings &board,
                                               const TuningSettings &tuning,
                                               const ModelScales &scales, const Model &m,
                                               const Bases &b)
{
    const bool crossing = scales.dead_time_s > 0 || scales.device_drop_v > 0;
    const double floor = crossing ? tuning.current_floor_pct / 100 : 0;
    TuningSettings own = tuning;
    if (!(own.startup_current_pct > 0)) {
        own.startup_current_pct = 100;
    }
    current_reference_cfg_t c{};
    const double least = std::min(floor * continuous_current(motor), stiff_current(motor));
    keep(c.floor, least / b.current_a * Q15, 0, Q14);
    const bool gives_over = tuning.method == ControlMethod::voltage_phase;
    c.floor_shift = gives_over ? 0 : 1;
    c.slope = hold_slope(motor, board, own, m, b);
    c.slope_down = current_fall(c.slope, least, motor, tuning);
    c.most_torque = tuning.most_torque != 0 && !gives_over ? 1 : 0;
    if (c.most_torque != 0) {
        check_most_torque(motor);
    }
    keep(c.deepest, deepest_current(motor, tuning) / b.current_a * Q15, 0, Q14);
    return c;
}

} // namespace nf
