/* SPDX-License-Identifier: MIT */
// What turning settings into the firmware's numbers is made of: formats, ranges, mantissas.
#pragma once

#include "si.h"

extern "C" {
#include "pi.h"
}

#include <algorithm>
#include <cmath>
#include <cstdint>

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

// The range of a current, as a refusal says it.
constexpr const char *CURRENT_REASON = "the firmware's steps of current";

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

} // namespace nf
