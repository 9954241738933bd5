/* SPDX-License-Identifier: MIT */
/*
 * Sine, cosine, arctangent and square root against libm, over whole ranges where that is possible.
 */
#include "figure.h"
#include "seeded.h"
#include "testing.h"
#include "trig.h"

#include <math.h>
#include <stdint.h>

#define TURN (4294967296.0) /* angle units in a turn */
#define TWO_PI (6.283185307179586)
#define AMPLITUDE (32767.0)
#define EIGHTH_TURN (0x20000000U)
#define QUARTER_TURN (0x40000000U)
#define HALF_TURN (0x80000000U)

/*
 * Largest error of sine and cosine in LSB, from its sources:
 *   interpolation between 1024 points a turn: (2π/1024)²/8 · 32767   0.1542
 *   entry rounded to a multiple of 2^12 of 2^-16: ½ · 2^-4            0.0313
 *   slope rounded, ½ of 2^-3 of 2^-13 · 2^13 of the fraction          0.0625
 *   result rounding                                                  0.5
 *   fraction cut to 13 bits, largest slope 2π·32767/1024 a point     201.1 / 2^13 = 0.0246
 */
#define SIN_BOUND_LSB (0.7726)

/*
 * Largest error of the arctangent in angle units, from its sources:
 *   ratio cut to 16 bits, slope ≤ 1: 2^-16 rad            2^32 · 2^-16 / 2π = 10430
 *   table rounding, half of 2^13                                               4096
 *   interpolation between 257 points: (1/256)²/8 · 0.65 rad                      848
 * The last entry is a further half unit low (65535.5 short of 65536); there the slope is ½, so the
 * cut ratio costs only 5215 and the sum is lower. All together below the documented 2^-17 turn.
 */
#define ATAN_BOUND (15374.0)
#define ATAN_DOCUMENTED (32768.0) /* 2^-17 turn */

/*
 * A measured maximum far below its bound would mean that the bound, or the measurement, is wrong.
 */
#define LEAST_SHARE (0.5)

#define SEEDED_CASES (400000)
#define SMALL_VECTOR (300)
#define CELL_STRIDE (1U) /* 1: a proof over all inputs */

static double larger(double a, double b)
{
    return (a > b) ? a : b;
}

static double sine_error(angle_t angle)
{
    return fabs((double)trig_sincos(angle).sin -
                (AMPLITUDE * sin(TWO_PI * ((double)angle / TURN))));
}

static double cosine_error(angle_t angle)
{
    return fabs((double)trig_sincos(angle).cos -
                (AMPLITUDE * cos(TWO_PI * ((double)angle / TURN))));
}

TEST(test_sine_and_cosine_of_all_65536_directions_stay_within_the_bound)
{
    double worst = 0.0;

    for (uint32_t k = 0U; k < 65536U; k++) {
        worst = larger(worst, larger(sine_error(k << 16U), cosine_error(k << 16U)));
    }
    figure_check("sine and cosine, 65536 directions, LSB", worst, SIN_BOUND_LSB, LEAST_SHARE);
}

TEST(test_sine_and_cosine_of_seeded_angles_stay_within_the_bound)
{
    seeded_t seed = {0xA5A5F00DU};
    double worst = 0.0;

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const angle_t angle = seeded_u32(&seed);

        worst = larger(worst, larger(sine_error(angle), cosine_error(angle)));
    }
    figure_check("sine and cosine, seeded angles, LSB", worst, SIN_BOUND_LSB, LEAST_SHARE);
}

/* The result depends on the upper 23 bits only; the lower 9 move the true angle within the cell. */
TEST(test_sine_of_every_distinct_input_stays_within_the_bound)
{
    double worst = 0.0;

    for (uint32_t cell = 0U; cell < (1U << 23U); cell += CELL_STRIDE) {
        worst = larger(worst, sine_error(cell << 9U));
        worst = larger(worst, sine_error((cell << 9U) + 511U));
    }
    figure_check("sine, all table cells, LSB", worst, SIN_BOUND_LSB, LEAST_SHARE);
}

TEST(test_cosine_is_the_sine_a_quarter_turn_on)
{
    seeded_t seed = {0x0BADF00DU};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const angle_t angle = seeded_u32(&seed);

        TEST_ASSERT_EQUAL_INT16(trig_sincos(angle + QUARTER_TURN).sin, trig_sincos(angle).cos);
    }
}

TEST(test_sine_is_exact_on_the_axes)
{
    TEST_ASSERT_EQUAL_INT16(0, trig_sincos(0U).sin);
    TEST_ASSERT_EQUAL_INT16(32767, trig_sincos(0U).cos);
    TEST_ASSERT_EQUAL_INT16(32767, trig_sincos(QUARTER_TURN).sin);
    TEST_ASSERT_EQUAL_INT16(0, trig_sincos(QUARTER_TURN).cos);
    TEST_ASSERT_EQUAL_INT16(0, trig_sincos(HALF_TURN).sin);
    TEST_ASSERT_EQUAL_INT16(-32767, trig_sincos(HALF_TURN).cos);
    TEST_ASSERT_EQUAL_INT16(-32767, trig_sincos(HALF_TURN + QUARTER_TURN).sin);
    TEST_ASSERT_EQUAL_INT16(0, trig_sincos(HALF_TURN + QUARTER_TURN).cos);
}

/*
 * At the points of the table nothing is interpolated: the error is the rounding of the result, ½,
 * and of the entry, 1/32. So the sine is odd and the cosine even to within twice that: as integers,
 * 1.
 */
TEST(test_sine_of_the_table_points_is_rounded_and_symmetric)
{
    double worst = 0.0;

    for (uint32_t k = 0U; k < 1024U; k++) {
        const angle_t angle = k << 22U;

        worst = larger(worst, larger(sine_error(angle), cosine_error(angle)));
        TEST_ASSERT_INT32_WITHIN(1, -trig_sincos(angle).sin, trig_sincos(0U - angle).sin);
        TEST_ASSERT_INT32_WITHIN(1, trig_sincos(angle).cos, trig_sincos(0U - angle).cos);
    }
    figure_check("sine and cosine, table points, LSB", worst, 0.5 + (1.0 / 32.0), 0.9);
}

TEST(test_sine_never_leaves_its_amplitude)
{
    for (uint32_t cell = 0U; cell < (1U << 23U); cell += CELL_STRIDE) {
        const sincos_t s = trig_sincos(cell << 9U);

        TEST_ASSERT_TRUE((s.sin >= -32767) && (s.sin <= 32767));
        TEST_ASSERT_TRUE((s.cos >= -32767) && (s.cos <= 32767));
    }
}

/* Distance of the result from the exact direction of (x, y), in angle units, by the shorter way. */
static double atan2_error(int16_t y, int16_t x)
{
    const double exact = atan2((double)y, (double)x) / TWO_PI * TURN;
    const double difference = (double)trig_atan2(y, x) - exact;

    return fabs(remainder(difference, TURN));
}

TEST(test_arctangent_of_all_65536_directions_stays_within_the_bound)
{
    double worst = 0.0;

    for (uint32_t k = 0U; k < 65536U; k++) {
        const double direction = TWO_PI * (double)k / 65536.0;
        const int16_t x = (int16_t)lround(AMPLITUDE * cos(direction));
        const int16_t y = (int16_t)lround(AMPLITUDE * sin(direction));

        worst = larger(worst, atan2_error(y, x));
    }
    TEST_ASSERT_TRUE(ATAN_BOUND <= ATAN_DOCUMENTED);
    figure_check("arctangent, 65536 directions, 2^-32 turn", worst, ATAN_BOUND, LEAST_SHARE);
}

TEST(test_arctangent_of_every_small_vector_stays_within_the_bound)
{
    double worst = 0.0;

    for (int32_t y = -SMALL_VECTOR; y <= SMALL_VECTOR; y++) {
        for (int32_t x = -SMALL_VECTOR; x <= SMALL_VECTOR; x++) {
            if ((x != 0) || (y != 0)) {
                worst = larger(worst, atan2_error((int16_t)y, (int16_t)x));
            }
        }
    }
    figure_check("arctangent, small vectors, 2^-32 turn", worst, ATAN_BOUND, LEAST_SHARE);
}

TEST(test_arctangent_of_seeded_vectors_stays_within_the_bound)
{
    seeded_t seed = {0x51ED270BU};
    double worst = 0.0;

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        worst = larger(worst, atan2_error(seeded_i16(&seed), seeded_i16(&seed)));
    }
    figure_check("arctangent, seeded vectors, 2^-32 turn", worst, ATAN_BOUND, LEAST_SHARE);
}

TEST(test_arctangent_is_exact_on_axes_and_diagonals_of_any_length)
{
    static const int16_t lengths[] = {1, 2, 3, 255, 256, 16384, 32766, 32767};

    for (uint32_t i = 0U; i < (sizeof lengths / sizeof lengths[0]); i++) {
        const int16_t r = lengths[i];

        TEST_ASSERT_EQUAL_HEX32(0U, trig_atan2(0, r));
        TEST_ASSERT_EQUAL_HEX32(EIGHTH_TURN, trig_atan2(r, r));
        TEST_ASSERT_EQUAL_HEX32(QUARTER_TURN, trig_atan2(r, 0));
        TEST_ASSERT_EQUAL_HEX32(QUARTER_TURN + EIGHTH_TURN, trig_atan2(r, (int16_t)-r));
        TEST_ASSERT_EQUAL_HEX32(HALF_TURN, trig_atan2(0, (int16_t)-r));
        TEST_ASSERT_EQUAL_HEX32(HALF_TURN + EIGHTH_TURN, trig_atan2((int16_t)-r, (int16_t)-r));
        TEST_ASSERT_EQUAL_HEX32(HALF_TURN + QUARTER_TURN, trig_atan2((int16_t)-r, 0));
        TEST_ASSERT_EQUAL_HEX32(0U - EIGHTH_TURN, trig_atan2((int16_t)-r, r));
    }
}

TEST(test_arctangent_takes_the_most_negative_components)
{
    TEST_ASSERT_EQUAL_HEX32(HALF_TURN, trig_atan2(0, INT16_MIN));
    TEST_ASSERT_EQUAL_HEX32(HALF_TURN + QUARTER_TURN, trig_atan2(INT16_MIN, 0));
    TEST_ASSERT_EQUAL_HEX32(HALF_TURN + EIGHTH_TURN, trig_atan2(INT16_MIN, INT16_MIN));
    TEST_ASSERT_TRUE(atan2_error(INT16_MIN, 1) <= ATAN_BOUND);
    TEST_ASSERT_TRUE(atan2_error(1, INT16_MIN) <= ATAN_BOUND);
    TEST_ASSERT_TRUE(atan2_error(INT16_MIN, INT16_MAX) <= ATAN_BOUND);
}

TEST(test_arctangent_of_the_null_vector_is_zero)
{
    TEST_ASSERT_EQUAL_HEX32(0U, trig_atan2(0, 0));
}

TEST(test_arctangent_rises_through_the_octant_without_a_step_back)
{
    angle_t before = 0U;

    for (int32_t y = 1; y <= 32767; y++) {
        const angle_t angle = trig_atan2((int16_t)y, 32767);

        TEST_ASSERT_TRUE(angle >= before);
        before = angle;
    }
    TEST_ASSERT_EQUAL_HEX32(EIGHTH_TURN, before);
}

TEST(test_square_root_is_exact_around_every_perfect_square)
{
    for (uint32_t root = 1U; root <= 65535U; root++) {
        const uint32_t square = root * root;

        TEST_ASSERT_EQUAL_UINT16(root - 1U, trig_sqrt(square - 1U));
        TEST_ASSERT_EQUAL_UINT16(root, trig_sqrt(square));
        TEST_ASSERT_EQUAL_UINT16(root, trig_sqrt(square + 1U));
    }
}

TEST(test_square_root_of_the_ends_of_the_range)
{
    TEST_ASSERT_EQUAL_UINT16(0U, trig_sqrt(0U));
    TEST_ASSERT_EQUAL_UINT16(1U, trig_sqrt(1U));
    TEST_ASSERT_EQUAL_UINT16(1U, trig_sqrt(3U));
    TEST_ASSERT_EQUAL_UINT16(65535U, trig_sqrt(UINT32_MAX));
}

static void assert_floor_of_root(uint32_t x)
{
    const uint64_t root = trig_sqrt(x);

    TEST_ASSERT_TRUE(((root * root) <= x) && (((root + 1U) * (root + 1U)) > x));
}

TEST(test_square_root_is_the_floor_for_seeded_arguments)
{
    seeded_t seed = {0x7F4A7C15U};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        assert_floor_of_root(seeded_u32(&seed) >> (uint32_t)(i % 32));
    }
}

/*
 * Arguments are shifted left by pairs of bits until one of the upper two is set; the upper 8 choose
 * the entry.
 */
TEST(test_square_root_is_the_floor_at_the_edges_of_every_table_interval)
{
    for (uint32_t interval = 64U; interval < 256U; interval++) {
        for (uint32_t pairs = 0U; pairs < 16U; pairs++) {
            const uint32_t first = (interval << 24U) >> (2U * pairs);
            const uint32_t last = ((interval << 24U) | 0xFFFFFFU) >> (2U * pairs);

            assert_floor_of_root(first);
            assert_floor_of_root(first + 1U);
            assert_floor_of_root(last - 1U);
            assert_floor_of_root(last);
        }
    }
}
