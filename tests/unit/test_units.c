/* SPDX-License-Identifier: MIT */
/* Units for a person, over all that the keys of motor and board file allow. */
#include "testing.h"
#include "units.h"

#include <math.h>

#define POLE_PAIRS_MAX (50U)
#define TICK_PS_MIN (10000000U)  /* 100 kHz */
#define TICK_PS_MAX (500000000U) /* 2 kHz */
#define TICKS (40U)
#define RPM_MAX (200000)
#define BASE_MIN (100000U)     /* 0.1 A */
#define BASE_MAX (4000000000U) /* twice 2000 A */
#define NEAREST (0.5)
/* of the expected values: 2^62 has 53 bits, and a quotient of some 10^6 is left */
#define DOUBLES (1e-6)

/* From the shortest tick to the longest. */
static uint32_t tick_ps_of(uint32_t at)
{
    const double ratio = (double)TICK_PS_MAX / TICK_PS_MIN;

    return (uint32_t)lround(TICK_PS_MIN * pow(ratio, (double)at / TICKS));
}

static double exact_rpm(const units_rotation_t *rotation, double step)
{
    const double turns_per_tick = step / 4294967296.0 / rotation->pole_pairs;

    return turns_per_tick / (rotation->tick_ps * 1e-12) * 60.0;
}

static void each_rotation(void (*check)(const units_rotation_t *rotation))
{
    for (uint32_t pairs = 1U; pairs <= POLE_PAIRS_MAX; pairs++) {
        for (uint32_t at = 0U; at <= TICKS; at++) {
            const units_rotation_t rotation = {.pole_pairs = pairs, .tick_ps = tick_ps_of(at)};

            check(&rotation);
        }
    }
}

static void check_rpm(const units_rotation_t *rotation)
{
    static const step_t steps[] = {INT32_MIN, INT32_MIN + 1, -40000001, -12345,  -1,       0,
                                   1,         54321,         76543210,  1 << 30, INT32_MAX};

    for (uint32_t k = 0U; k < (sizeof(steps) / sizeof(steps[0])); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(NEAREST + DOUBLES, exact_rpm(rotation, steps[k]),
                                  units_rpm(rotation, steps[k]));
    }
}

TEST(test_rpm_is_the_nearest_for_all_pole_pairs_and_ticks)
{
    each_rotation(check_rpm);
}

static void check_step(const units_rotation_t *rotation)
{
    static const int32_t speeds[] = {-RPM_MAX, -99999, -250, -1, 0, 1, 250, 4001, 99999, RPM_MAX};

    for (uint32_t k = 0U; k < (sizeof(speeds) / sizeof(speeds[0])); k++) {
        const double exact = speeds[k] / exact_rpm(rotation, 1.0);

        if (fabs(exact) < INT32_MAX) {
            const step_t step = units_step(rotation, speeds[k]);

            TEST_ASSERT_DOUBLE_WITHIN(NEAREST + DOUBLES, exact, step);
            TEST_ASSERT_EQUAL_INT32(speeds[k], units_rpm(rotation, step));
        }
    }
}

TEST(test_a_speed_comes_back_from_its_step_for_all_pole_pairs_and_ticks)
{
    each_rotation(check_step);
}

static void check_saturation(const units_rotation_t *rotation)
{
    const double one_rpm = 1.0 / exact_rpm(rotation, 1.0);

    TEST_ASSERT_DOUBLE_WITHIN(one_rpm + 1.0, INT32_MAX, units_step(rotation, INT32_MAX));
    TEST_ASSERT_DOUBLE_WITHIN(one_rpm + 1.0, INT32_MIN, units_step(rotation, INT32_MIN));
}

TEST(test_a_speed_beyond_all_steps_saturates_for_all_pole_pairs_and_ticks)
{
    each_rotation(check_saturation);
}

/* The numbers that used to wrap: 16 pole pairs at 16 kHz are 250 rpm at this step. */
TEST(test_sixteen_pole_pairs_at_16_khz)
{
    const units_rotation_t rotation = {.pole_pairs = 16U, .tick_ps = 62500000U};

    TEST_ASSERT_EQUAL_INT32(17895697, units_step(&rotation, 250)); /* 2^32 · 16 · 250/60 / 16000 */
    TEST_ASSERT_EQUAL_INT32(250, units_rpm(&rotation, 17895697));
}

TEST(test_thousandths_are_cut_towards_zero_for_all_bases)
{
    static const int32_t values[] = {-65535, -32768, -2048, -1, 0, 1, 1023, 32767, 46340};

    for (double base = BASE_MIN; base <= BASE_MAX; base *= 1.1) {
        const uint32_t millionths = (uint32_t)base;

        for (uint32_t k = 0U; k < (sizeof(values) / sizeof(values[0])); k++) {
            const double exact = values[k] / 32768.0 * millionths / 1000.0;

            TEST_ASSERT_EQUAL_INT32((int32_t)trunc(exact),
                                    units_thousandths(values[k], 32768, millionths));
        }
    }
}

TEST(test_thousandths_saturate)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, units_thousandths(INT32_MAX, 1, UINT32_MAX));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, units_thousandths(INT32_MIN, 1, UINT32_MAX));
    TEST_ASSERT_EQUAL_INT32(-1000, units_thousandths(-16384, 16384, 1000000U));
}

TEST(test_a_frequency_is_that_of_half_as_many_waves_in_the_time)
{
    const units_rotation_t rotation = {.pole_pairs = 7U, .tick_ps = 62500000U};

    TEST_ASSERT_EQUAL_INT32(250, units_decihertz(&rotation, 20U, 6400U)); /* 10 waves in 0.4 s */
    TEST_ASSERT_EQUAL_INT32(33, units_decihertz(&rotation, 1U, 2400U));   /* 3.33 Hz */
    TEST_ASSERT_EQUAL_INT32(67, units_decihertz(&rotation, 2U, 2400U));   /* 6.67 Hz */
    TEST_ASSERT_EQUAL_INT32(80000000, units_decihertz(&rotation, 1000U, 1U));
}

TEST(test_a_frequency_is_nothing_in_no_time_and_ends_at_both_ends_of_time)
{
    const units_rotation_t fastest = {.pole_pairs = 1U, .tick_ps = 1U};
    const units_rotation_t slowest = {.pole_pairs = 1U, .tick_ps = 500000000U};

    TEST_ASSERT_EQUAL_INT32(0, units_decihertz(&slowest, 20U, 0U));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, units_decihertz(&fastest, 1000U, 1U));
    TEST_ASSERT_EQUAL_INT32(0, units_decihertz(&slowest, 1U, UINT32_MAX));
}

TEST(test_ticks_of_a_time_are_whole_ones_and_at_least_one)
{
    const units_rotation_t ten_khz = {.pole_pairs = 1U, .tick_ps = 100000000U};
    const units_rotation_t two_khz = {.pole_pairs = 1U, .tick_ps = 500000000U};

    TEST_ASSERT_EQUAL_UINT32(20000U, units_ticks(&ten_khz, 2000000U));
    TEST_ASSERT_EQUAL_UINT32(80U, units_ticks(&ten_khz, 8099U));
    TEST_ASSERT_EQUAL_UINT32(20000U, units_ticks(&two_khz, 10000000U));
    TEST_ASSERT_EQUAL_UINT32(1U, units_ticks(&two_khz, 1U));
}

/*
 * Of 2 pole pairs a turn is 131072: a hundredth is 1310.72, and half of one rounds away from zero.
 */
TEST(test_a_position_is_in_hundredths_of_a_turn_over_its_whole_range)
{
    static const units_rotation_t two = {.pole_pairs = 2U, .tick_ps = 100000000U};
    static const units_rotation_t one = {.pole_pairs = 1U, .tick_ps = 100000000U};

    TEST_ASSERT_EQUAL_INT32(0, units_hundredth_turns(&two, 655));
    TEST_ASSERT_EQUAL_INT32(1, units_hundredth_turns(&two, 656));
    TEST_ASSERT_EQUAL_INT32(0, units_hundredth_turns(&two, -655));
    TEST_ASSERT_EQUAL_INT32(-1, units_hundredth_turns(&two, -656));
    TEST_ASSERT_EQUAL_INT32(300, units_hundredth_turns(&two, 6 * 65536));
    TEST_ASSERT_EQUAL_INT32(3276800, units_hundredth_turns(&one, INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(-3276800, units_hundredth_turns(&one, INT32_MIN));
}

/* T_b = 1.5·P·U_b·I_b/Ω_b in µN·m, Ω_b = 2π·2^(shift − 17)/tick, I_b twice the full scale. */
static double exact_torque_base(const units_rotation_t *rotation, double ua, double uv,
                                uint32_t speed_shift)
{
    const double omega = 6.283185307179586 * pow(2.0, (double)speed_shift - 17.0) /
                         ((double)rotation->tick_ps * 1e-12);

    return 1.5 * rotation->pole_pairs * (uv * 1e-6) * (2.0 * ua * 1e-6) / omega * 1e6;
}

TEST(test_the_base_of_a_torque_is_right_for_all_scales_of_a_watt_and_more)
{
    static const uint32_t amperes_ua[] = {100000U, 4000000U, 20000000U, 2000000000U};
    static const uint32_t volts_uv[] = {10000000U, 24000000U, 450000000U, 2000000000U};

    for (uint32_t at = 0U; at <= TICKS; at++) {
        const units_rotation_t rotation = {.pole_pairs = 1U + at, .tick_ps = tick_ps_of(at)};

        for (uint32_t k = 0U; k < 16U; k++) {
            const uint32_t shift = 1U + ((at + k) % 16U);
            const uint32_t ua = amperes_ua[k % 4U];
            const uint32_t uv = volts_uv[k / 4U];
            const double exact =
                fmin(exact_torque_base(&rotation, ua, uv, shift), 70368744177664.0);

            TEST_ASSERT_DOUBLE_WITHIN((1e-3 * exact) + 1.0, exact,
                                      (double)units_torque_base(&rotation, ua, uv, shift));
        }
    }
}

/*
 * Whole mW and whole ns lose nothing: what is left is 3/(2π)·2^17 as 62582, 4.3·10^-6 less, and
 * digits of 10^-9.
 */
TEST(test_the_base_of_a_torque_of_whole_milliwatts_and_nanoseconds_is_right_to_five_millionths)
{
    static const uint32_t shifts[] = {1U, 6U, 10U};
    const units_rotation_t rotation = {.pole_pairs = 4U, .tick_ps = 100000000U};

    for (uint32_t k = 0U; k < (sizeof(shifts) / sizeof(shifts[0])); k++) {
        const double exact = exact_torque_base(&rotation, 20000000.0, 450000000.0, shifts[k]);

        TEST_ASSERT_DOUBLE_WITHIN(
            5e-6 * exact, exact,
            (double)units_torque_base(&rotation, 20000000U, 450000000U, shifts[k]));
    }
}

TEST(test_a_torque_comes_back_from_its_number_and_saturates)
{
    static const int64_t bases[] = {1000, 50000, 48892000, 4000000000LL, 70368744177664LL};

    for (uint32_t k = 0U; k < 5U; k++) {
        for (int32_t torque = -2000000000; torque <= 1900000000; torque += 98765432) {
            const int32_t q28 = units_torque_q28(bases[k], torque);
            const double exact = (double)torque * 268435456.0 / (double)bases[k];
            /* rounded twice, by a unit of either */
            const double step = 2.0 + ((double)bases[k] / 268435456.0);

            if (fabs(exact) > 2147483647.0) {
                TEST_ASSERT_EQUAL_INT32((torque < 0) ? -INT32_MAX : INT32_MAX, q28);
            } else {
                TEST_ASSERT_DOUBLE_WITHIN(1.0, exact, q28);
                TEST_ASSERT_DOUBLE_WITHIN(step, torque, units_torque(bases[k], q28));
            }
        }
    }
    TEST_ASSERT_EQUAL_INT32(0, units_torque_q28(0, 1000));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, units_torque(70368744177664LL, 0x20000000));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, units_torque(70368744177664LL, -0x20000000));
}
