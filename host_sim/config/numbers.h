/* SPDX-License-Identifier: MIT */
// What turning settings into the firmware's numbers is made of: ranges, mantissas, the motor model.
#pragma once

#include "per_unit.h"
#include "si.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace nf
{

constexpr double STEPS_PER_TURN = 4294967296.0; // step_t and angle_t: 2^32
constexpr double Q12 = 4096.0;
constexpr double Q13 = 8192.0;
constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q27 = 134217728.0;
constexpr double Q28 = 268435456.0;
constexpr double Q30 = 1073741824.0;
constexpr double MANTISSA_MAX = 32767.0;

inline double rad_s_from_rpm(double rpm)
{
    return rpm * TWO_PI / 60.0;
}

// The largest −i_d that field weakening asks for: its share of the largest current, and no more than the magnets bear.
double deepest_current(const MotorSettings &motor, const TuningSettings &tuning);

// The largest phase voltage as a share of the bus: the circle in the hexagon of the inverter.
double largest_ratio(const BoardSettings &board);

// The setting that a number follows from: the number goes with this power of it.
struct Source {
    const char *key;
    double value;
    double power = 1;
};

// Refuses a setting whose number is not within lo…hi, and says up to where it would be.
void require(double number, double lo, double hi, const Source &setting, const char *what);

// Likewise for a limit in the setting's own unit.
void require(const Source &setting, double lo, double hi, const char *what);

// A number that no file writes: rounded, and kept within what the field holds.
template <typename Field> void keep(Field &field, double number, double lo, double hi)
{
    field = static_cast<Field>(std::round(std::clamp(number, lo, hi)));
}

// A number rounded to an integer field, refused where the field cannot hold it.
template <typename Field>
void store(Field &field, double number, double lo, double hi, const Source &setting,
           const char *what)
{
    require(number, lo, hi, setting, what);
    field = static_cast<Field>(std::round(number));
}

struct Mantissa {
    int32_t value;
    uint32_t shift;
};

// number ≈ mantissa / 2^shift with as many significant bits as the shift range allows.
Mantissa normalise(double number, int shift_min, int shift_max, const Source &setting,
                   const char *what);

// Gains of a PI that follow from a bandwidth, ki (per sample) with a power of it.
pi_cfg_t make_pi(double kp, double ki, double ki_power, const char *key, double bandwidth);

// What the controller believes of the motor, in SI units.
struct Model {
    double resistance, inductance_d, inductance_q, flux, inertia;
    double flux_current;        // φ/L_d
    double torque_acceleration; // electrical rad/s² per ampere of i_q
    double max_speed_el;
};

Model make_model(const MotorSettings &motor, const ModelScales &scale);

// The lowest speed of the voltage drive is at least so many hand-over speeds: it gives back at 3/4 of it, which has to be
// before the observer does.
constexpr double ABOVE_HANDOVER = 1.5;

// With an angle sensor nothing is to be found at the start, and the observer's speed is not trained.
TuningSettings for_sensor(const TuningSettings &tuning);

// Peak phase current of rated torque, i_d = 0.
double rated_current(const MotorSettings &motor);

// Peak phase current for ever: the motor file's, else that of rated torque; and the key that says so.
double continuous_current(const MotorSettings &motor);
Source continuous_source(const MotorSettings &motor);

} // namespace nf
