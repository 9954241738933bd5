/* SPDX-License-Identifier: MIT */
#include "units.h"

/*
 * rpm = step / 2^32 turns / (pole_pairs · tick), and a minute is 6·10^13 ps. Both 2^32 and 6·10^13
 * contain the factor 2^14. It is divided out here, so that all products fit 64 bits: |step| ·
 * 3662109375 < 2^63, pole_pairs · tick_ps · 2^18 < 2^53.
 */
#define MINUTE (3662109375LL)
#define TURN (262144LL)

#define PS_OF_A_US (1000000U)

#define MICRO_IN_MILLI_SQUARED (1000000000ULL) /* µV·µA in mW */
#define TORQUE_MILLIONTHS (62582U)
#define TORQUE_BASE_MAX (70368744177664LL) /* 2^46 */
#define TORQUE_HALF (16384LL)
#define TORQUE_ONE (268435456LL)

static int64_t clamped(int64_t value, int64_t end)
{
    int64_t result = value;

    if (value > end) {
        result = end;
    } else if (value < -end) {
        result = -end;
    } else {
        /* within */
    }
    return result;
}

/* Returns value/divisor, rounded to nearest, halves away from zero. `divisor` > 0. */
static int64_t divided(int64_t value, int64_t divisor)
{
    const int64_t half = (value < 0) ? -(divisor / 2) : (divisor / 2);

    return (value + half) / divisor;
}

static int64_t turn_of(const units_rotation_t *rotation)
{
    return (int64_t)rotation->pole_pairs * (int64_t)rotation->tick_ps * TURN;
}

int32_t units_rpm(const units_rotation_t *rotation, step_t step)
{
    return (int32_t)divided((int64_t)step * MINUTE, turn_of(rotation));
}

/* The rpm is clamped first, so that the product fits 64 bits. */
step_t units_step(const units_rotation_t *rotation, int32_t rpm)
{
    const int64_t turn = turn_of(rotation);
    const int64_t largest = ((int64_t)INT32_MAX * MINUTE) / turn;

    return (step_t)divided(clamped(rpm, largest) * turn, MINUTE);
}

int32_t units_hundredth_turns(const units_rotation_t *rotation, int32_t position)
{
    return (int32_t)divided((int64_t)position * 100, (int64_t)rotation->pole_pairs * 65536);
}

/*
 * f = (halves/2)/(ticks·tick_ps·10^-12 s). In tenths of Hz this is halves·5·10^12/(ticks·tick_ps).
 * halves·5·10^12 stays below 2^53, ticks·tick_ps below 2^61.
 */
int32_t units_decihertz(const units_rotation_t *rotation, uint32_t halves, uint32_t ticks)
{
    const int64_t time_ps = (int64_t)ticks * (int64_t)rotation->tick_ps;

    return (time_ps == 0)
               ? 0
               : (int32_t)clamped(divided((int64_t)halves * 5000000000000LL, time_ps), INT32_MAX);
}

int32_t units_thousandths(int32_t value, int32_t one, uint32_t base_millionths)
{
    const int64_t product = (int64_t)value * (int64_t)base_millionths;

    return (int32_t)clamped(product / ((int64_t)one * 1000), INT32_MAX);
}

/*
 * Ω_b = 2π·2^(15 + shift)/2^32/tick and I_b is twice the full scale, so T_b =
 * 3/(2π)·P·U·I·tick·2^(17 − shift). U·I in mW is below 2^32, and tick·P in ns is below 2^25. The
 * unit of their product is 10^-12 J: times 3/(2π)·2^17 this is 0.062582 µN·m.
 */
int64_t units_torque_base(const units_rotation_t *rotation, uint32_t current_full_scale_ua,
                          uint32_t bus_full_scale_uv, uint32_t speed_shift)
{
    const uint64_t power =
        ((uint64_t)current_full_scale_ua * (uint64_t)bus_full_scale_uv) / MICRO_IN_MILLI_SQUARED;
    const uint64_t ticks = ((uint64_t)rotation->pole_pairs * (uint64_t)rotation->tick_ps) / 1000U;
    const uint64_t thousands = (power * ticks) / 1000U;

    const uint64_t base = ((thousands * TORQUE_MILLIONTHS) >> speed_shift) / 1000U;

    return clamped((int64_t)base, TORQUE_BASE_MAX);
}

/* Splits the torque into an upper and a lower half, so that the products fit 64 bits. */
int32_t units_torque(int64_t base, int32_t torque_q28)
{
    const int64_t upper = (int64_t)torque_q28 / TORQUE_HALF;
    const int64_t lower = (int64_t)torque_q28 % TORQUE_HALF;
    const int64_t scaled = (upper * base) + ((lower * base) / TORQUE_HALF);

    return (int32_t)clamped(scaled / TORQUE_HALF, INT32_MAX);
}

int32_t units_torque_q28(int64_t base, int32_t torque)
{
    return (base == 0) ? 0 : (int32_t)clamped(((int64_t)torque * TORQUE_ONE) / base, INT32_MAX);
}

uint32_t units_ticks(const units_rotation_t *rotation, uint32_t us)
{
    const uint64_t ticks = ((uint64_t)us * PS_OF_A_US) / rotation->tick_ps;

    return (ticks == 0U) ? 1U : (uint32_t)ticks;
}
