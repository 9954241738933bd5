/* SPDX-License-Identifier: MIT */
// Configurations of both motors for the comparisons.
#pragma once

#include "firmware.h"
#include "per_unit.h"
#include "twin_params.h"

#include <cstdint>
#include <random>

namespace nf::reference
{

using twin::current_loop_params;
using twin::observer_params;
using twin::pi_params;
using twin::position_loop_params;
using twin::Q13;
using twin::Q14;
using twin::Q15;
using twin::Q27;
using twin::radians_of_q32;
using twin::SINE_LSB;
using twin::speed_loop_params;
using twin::STEPS_PER_TURN;
using twin::TWO_PI;

inline MotorSettings motor_a()
{
    MotorSettings m;
    m.name = "A";
    m.pole_pairs = 2;
    m.resistance_ohm = 2.125;
    m.inductance_d_h = 0.0116;
    m.inductance_q_h = 0.0116;
    m.flux_linkage_wb = 0.387;
    m.rated_torque_nm = 7.8;
    m.rated_speed_rpm = 1800;
    m.max_speed_rpm = 2000;
    m.max_current_a = 10;
    m.inertia_kg_m2 = 0.003;
    return m;
}

inline MotorSettings motor_b()
{
    MotorSettings m;
    m.name = "B";
    m.pole_pairs = 2;
    m.resistance_ohm = 0.405;
    m.inductance_d_h = 0.0135;
    m.inductance_q_h = 0.0235;
    m.flux_linkage_wb = 0.375;
    m.rated_torque_nm = 4;
    m.rated_speed_rpm = 1200;
    m.max_speed_rpm = 1400;
    m.max_current_a = 8;
    m.inertia_kg_m2 = 0.011;
    return m;
}

inline BoardSettings board(double pwm_frequency_hz = 10000)
{
    BoardSettings b;
    b.name = "bench";
    b.pwm_frequency_hz = pwm_frequency_hz;
    b.timer_clock_hz = 170e6;
    b.adc_bits = 12;
    b.current_full_scale_a = 20;
    b.bus_full_scale_v = 450;
    b.bus_nominal_v = 310;
    b.bus_min_v = 200;
    b.bus_max_v = 400;
    b.overcurrent_a = 18;
    b.offset_max_a = 1;
    b.duty_margin_pct = 5;
    b.offset_samples_log2 = 8;
    return b;
}

inline TuningSettings tuning()
{
    TuningSettings t;
    t.name = "robust";
    t.observer_kappa = 0.005;
    t.observer_kappa_p = 0.1;
    t.current_bandwidth_hz = 500;
    t.speed_bandwidth_hz = 20;
    t.speed_damping = 1;
    t.speed_ramp_rpm_s = 10000;
    t.inertia_feed_forward = 1;
    t.position_bandwidth_hz = 5;
    t.position_speed_rpm = 900;
    t.position_acceleration_rad_s2 = 800;
    t.position_softness_s = 0.01;
    t.slow_ticks = 10;
    return t;
}

// The firmware's numbers for a motor.
struct Setup : twin::PerUnit {
    Setup(const MotorSettings &motor, const BoardSettings &board, const TuningSettings &tuning)
        : PerUnit{make_bases(motor, board), make_drive_cfg(motor, board, tuning, no_losses())}
    {
    }

    // The motor as in its file, and an inverter without dead time and drop.
    static ModelScales no_losses()
    {
        ModelScales scales;
        scales.dead_time_s = 0;
        scales.device_drop_v = 0;
        return scales;
    }
};

// Seeded numbers, the same with every library: no distribution classes.
class Seeded
{
public:
    explicit Seeded(uint32_t seed) : engine_(seed)
    {
    }

    int32_t in(int32_t lo, int32_t hi)
    {
        const auto span = static_cast<uint64_t>(static_cast<int64_t>(hi) - lo) + 1U;
        return static_cast<int32_t>(
            lo + static_cast<int64_t>((static_cast<uint64_t>(engine_()) * span) >> 32U));
    }

private:
    std::mt19937 engine_;
};

} // namespace nf::reference
