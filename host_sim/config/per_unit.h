/* SPDX-License-Identifier: MIT */
// From settings in SI units to the firmware's per-unit integers: the one place where this is done,
// for the simulator at run time and for the header that targets compile.
#pragma once

#include "settings.h"

extern "C" {
#include "config_guard.h"
#include "drive_cfg.h"
}

#include <stdexcept>
#include <string>

namespace nf
{

// Up to where a setting can be turned into the firmware's numbers, the others being as they are.
struct SettingLimit {
    bool at_most; // else at least
    double value; // in the setting's unit
};

// A setting that cannot be turned into the firmware's numbers. `key` is the one to change.
struct SettingError : std::runtime_error {
    SettingError(const char *key_, double value_, SettingLimit limit_, const char *reason_);
    std::string key;
    double value;
    SettingLimit limit;
    std::string reason;
};

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

// Bus current for one of current and voltage each: power is 1.5·(v_d·i_d + v_q·i_q). Q15 of it is the firmware's.
constexpr double BUS_CURRENT_FACTOR = 1.5;

// From the first tick until the drive runs: INIT, 2^offset_samples_log2 ticks of calibration, and the slow period in which
// the command is taken.
double calibration_time(const BoardSettings &board, const TuningSettings &tuning);

// The current that charges the capacitance of a leg's output just within the dead time, as the drive takes both; 0 without
// dead time.
double commutation_knee_a(const BoardSettings &board, const ModelScales &model);

// Counts of the power stage's temperature sensor, not rounded; beyond the converter's ends where the
// temperature is.
double temperature_count(const BoardSettings &board, double temperature_c);

// The other way: °C at a count; beyond the first and the last point their line goes on.
double temperature_at(const BoardSettings &board, double count);

Bases make_bases(const MotorSettings &motor, const BoardSettings &board);

// Those of a drive on the same motor and board that has this configuration: it chooses the scale of its speeds.
Bases rescaled(Bases bases, const drive_cfg_t &cfg);

// The tuning that acts: settings that are left to the motor (0) are filled in by rule, as far as the firmware's numbers
// hold; with an angle sensor, what finds the angle is off. Throws SettingError naming the offending key.
TuningSettings settled_tuning(const MotorSettings &motor, const BoardSettings &board,
                              const TuningSettings &as_written, const ModelScales &scales);

// The firmware's numbers of the tuning that acts. Throws SettingError naming the offending key, or logic_error if
// config_check refuses the result, which no settings within the ranges of the keys can bring about.
drive_cfg_t make_drive_cfg(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &as_written, const ModelScales &scales);

} // namespace nf
