/* SPDX-License-Identifier: MIT */
// What one of the firmware's numbers is in SI units: of currents, voltages, speeds and times.
#pragma once

#include "settings.h"

extern "C" {
#include "drive_cfg.h"
}

#include <cstdint>

namespace nf
{

// Bus current for one of current and voltage each: power is 1.5·(v_d·i_d + v_q·i_q). Q15 of it is
// the firmware's.
constexpr double BUS_CURRENT_FACTOR = 1.5;

// SI value of one per-unit step of each firmware quantity.
struct Bases {
    double control_period_s;
    double current_a;      // I_b: Q15 one; twice the converter's full scale
    double voltage_v;      // U_b: Q15 one
    double speed_el_rad_s; // Ω_b: Q15 one
    int speed_shift;       // Q15 of Ω_b = step >> speed_shift
    int pole_pairs;
    step_t speed_limit; // of the estimate; below Ω_b

    double torque_nm() const;               // T_b: Q28 one is the drive's unit of torque
    double step_from_rpm(double rpm) const; // mechanical rpm to step_t
    double rpm_from_step(double step) const;
    double turns_from_mech_rad(double rad) const; // mechanical angle to electrical turns
    double position_max_turns() const;            // whole turns of the shaft that a command holds
};

Bases make_bases(const MotorSettings &motor, const BoardSettings &board);

// Those of a drive on the same motor and board that has this configuration: it chooses the scale of
// its speeds.
Bases rescaled(Bases bases, const drive_cfg_t &cfg);

// Q15 of I_b, rounded.
int32_t current_q15(double current_a, const Bases &b);

// Ticks that take so long at least: 1…2^20.
uint32_t ticks(double seconds, const Bases &b);

// Likewise slow periods: 1…60000, which a counter of them is set to at most.
uint32_t slow_periods(double seconds, const TuningSettings &tuning, const Bases &b);

} // namespace nf
