/* SPDX-License-Identifier: MIT */
/* Clarke and Park transforms against their exact values, and their saturation. */
#include "figure.h"
#include "seeded.h"
#include "testing.h"
#include "transforms.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define SQRT3 (1.7320508075688772)
#define ONE (32768.0)
#define SEEDED_CASES (300000)
#define LEAST_SHARE (0.5)

/*
 * Clarke, LSB: 18919 stands for 32768/√3 = 18918.613, an error of 0.387 / 32768 on |a + 2b| ≤
 * 3·32767, at most 1.161. Rounding of the result: 0.5. Within the drive |a|, |b| ≤ 16383, so half
 * of the first.
 */
#define CLARKE_BOUND_LSB (1.662)
#define CLARKE_DRIVE_BOUND_LSB (1.081)
#define PHASE_LIMIT (16383)

/*
 * Park both ways, LSB, against the exact rotation by the integers of the sincos: products and sum
 * are exact, one rounding.
 */
#define ROTATION_BOUND_LSB (0.5)

/*
 * Park there and back. |v| ≤ 1, sine and cosine as given: (cos² + sin²)/2^30 differs from 1 by
 * twice the error of the sincos vector, ≤ 2·(1.161·√2 + 1)/32768 (table error in both, amplitude
 * 32767), so 5.28 LSB at full scale; two roundings in each of the two steps, the first pair
 * rotated: 0.5·√2 + 0.5.
 */
#define ROUND_TRIP_BOUND_LSB (6.5)
#define ROUND_TRIP_SHARE (0.3)

TEST(test_clarke_passes_phase_a_unchanged)
{
    TEST_ASSERT_EQUAL_INT32(-32767, transforms_clarke(-32767, 0).alpha);
    TEST_ASSERT_EQUAL_INT32(32767, transforms_clarke(32767, -32767).alpha);
    TEST_ASSERT_EQUAL_INT32(0, transforms_clarke(0, 12345).alpha);
}

/* Largest error of β over every sum a + 2b that phases up to `limit` can have. */
static double worst_clarke_error(int32_t limit)
{
    double worst = 0.0;

    for (int32_t sum = -3 * limit; sum <= 3 * limit; sum++) {
        /* b to the nearest third, so that |a| ≤ limit too. */
        const int32_t b = (sum + ((sum > 0) ? 1 : -1)) / 3;
        const int32_t a = sum - (2 * b);

        TEST_ASSERT_TRUE((a >= -limit) && (a <= limit));
        worst = fmax(worst, fabs(transforms_clarke(a, b).beta - ((double)sum / SQRT3)));
    }
    return worst;
}

TEST(test_clarke_beta_of_every_possible_sum_stays_within_the_bound)
{
    figure_check("Clarke beta, all inputs, LSB", worst_clarke_error(32767), CLARKE_BOUND_LSB,
                 LEAST_SHARE);
    figure_check("Clarke beta, inputs of the drive, LSB", worst_clarke_error(PHASE_LIMIT),
                 CLARKE_DRIVE_BOUND_LSB, LEAST_SHARE);
}

TEST(test_clarke_beta_holds_the_largest_sums_without_saturation)
{
    /* √3·32767 = 56754.1; the constant's error adds 1.16. */
    TEST_ASSERT_INT32_WITHIN(2, 56754, transforms_clarke(32767, 32767).beta);
    TEST_ASSERT_INT32_WITHIN(2, -56754, transforms_clarke(-32767, -32767).beta);
}

TEST(test_clarke_beta_rounds_ties_up)
{
    /* (a + 2b)·18919 is an odd multiple of 2^14 at a + 2b = ±2^14: 9459.5. */
    TEST_ASSERT_EQUAL_INT32(9460, transforms_clarke(0, 8192).beta);
    TEST_ASSERT_EQUAL_INT32(-9459, transforms_clarke(0, -8192).beta);
}

TEST(test_clarke_of_a_balanced_rotating_system_is_that_vector)
{
    /* Phase rounding 0.5 LSB each: (0.5 + 2·0.5)/√3 = 0.87 on top of the transform's own error. */
    const double bound = CLARKE_BOUND_LSB + 0.87;
    double worst = 0.0;

    for (int32_t k = 0; k < 3600; k++) {
        const double angle = (double)k * (3.141592653589793 / 1800.0);
        const int32_t a = (int32_t)lround(30000.0 * cos(angle));
        const int32_t b = (int32_t)lround(30000.0 * cos(angle - (3.141592653589793 * 2.0 / 3.0)));

        worst = fmax(worst, fabs(transforms_clarke(a, b).beta - (30000.0 * sin(angle))));
    }
    figure_check("Clarke of a rotating vector, LSB", worst, bound, LEAST_SHARE);
}

TEST(test_park_rounds_the_exact_rotation_to_nearest)
{
    seeded_t seed = {0x12345679U};
    double worst = 0.0;

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const ab_t v = {seeded_in(&seed, -32767, 32767), seeded_in(&seed, -32767, 32767)};
        const sincos_t s = trig_sincos(seeded_u32(&seed));
        const dq_t r = transforms_park(v, s);
        const double d = (((double)v.alpha * s.cos) + ((double)v.beta * s.sin)) / ONE;
        const double q = (((double)v.beta * s.cos) - ((double)v.alpha * s.sin)) / ONE;

        worst = fmax(worst, fmax(fabs(r.d - d), fabs(r.q - q)));
    }
    figure_check("Park, LSB", worst, ROTATION_BOUND_LSB, LEAST_SHARE);
}

TEST(test_inverse_park_rounds_the_exact_rotation_to_nearest)
{
    seeded_t seed = {0x87654321U};
    double worst = 0.0;

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const dq_t v = {seeded_in(&seed, -32767, 32767), seeded_in(&seed, -32767, 32767)};
        const sincos_t s = trig_sincos(seeded_u32(&seed));
        const ab_t r = transforms_park_inverse(v, s);
        const double alpha = (((double)v.d * s.cos) - ((double)v.q * s.sin)) / ONE;
        const double beta = (((double)v.d * s.sin) + ((double)v.q * s.cos)) / ONE;

        worst = fmax(worst, fmax(fabs(r.alpha - alpha), fabs(r.beta - beta)));
    }
    figure_check("inverse Park, LSB", worst, ROTATION_BOUND_LSB, LEAST_SHARE);
}

TEST(test_park_puts_a_vector_along_the_rotor_flux_on_the_d_axis)
{
    const sincos_t quarter = {.sin = 32767, .cos = 0};
    const dq_t r = transforms_park((ab_t){.alpha = 0, .beta = 20000}, quarter);

    TEST_ASSERT_EQUAL_INT32(19999, r.d); /* 20000·32767/32768 = 19999.4 */
    TEST_ASSERT_EQUAL_INT32(0, r.q);
}

TEST(test_park_puts_a_vector_a_quarter_turn_ahead_on_the_positive_q_axis)
{
    const sincos_t zero = {.sin = 0, .cos = 32767};
    const dq_t r = transforms_park((ab_t){.alpha = 0, .beta = 20000}, zero);

    TEST_ASSERT_EQUAL_INT32(0, r.d);
    TEST_ASSERT_EQUAL_INT32(19999, r.q);
}

TEST(test_park_rounds_ties_up)
{
    const sincos_t half = {.sin = 0, .cos = 16384};

    TEST_ASSERT_EQUAL_INT32(2, transforms_park((ab_t){.alpha = 3, .beta = 0}, half).d);
    TEST_ASSERT_EQUAL_INT32(-1, transforms_park((ab_t){.alpha = -3, .beta = 0}, half).d);
}

TEST(test_rotations_hold_the_largest_vectors_without_overflow)
{
    /*
     * |α| + |β| = 65534 along the diagonal of the frame: √2·32767 = 46339.5, sincos 23170/32768
     * each.
     */
    static const int32_t signs[][2] = {{1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
    const sincos_t eighth = trig_sincos(0x20000000U);

    for (uint32_t i = 0U; i < 4U; i++) {
        const int32_t u = signs[i][0] * 32767;
        const int32_t v = signs[i][1] * 32767;
        const double plus = (double)(u + v) * 23170.0 / ONE;
        const double minus = (double)(v - u) * 23170.0 / ONE;
        const dq_t dq = transforms_park((ab_t){u, v}, eighth);
        const ab_t ab = transforms_park_inverse((dq_t){u, v}, eighth);

        TEST_ASSERT_DOUBLE_WITHIN(ROTATION_BOUND_LSB, plus, dq.d);
        TEST_ASSERT_DOUBLE_WITHIN(ROTATION_BOUND_LSB, minus, dq.q);
        TEST_ASSERT_DOUBLE_WITHIN(ROTATION_BOUND_LSB, -minus, ab.alpha);
        TEST_ASSERT_DOUBLE_WITHIN(ROTATION_BOUND_LSB, plus, ab.beta);
    }
    /* A vector along one axis may use the whole sum. */
    TEST_ASSERT_EQUAL_INT32(65532, transforms_park((ab_t){65534, 0}, trig_sincos(0U)).d);
    TEST_ASSERT_EQUAL_INT32(-65532, transforms_park((ab_t){-65534, 0}, trig_sincos(0U)).d);
}

TEST(test_park_and_back_returns_the_vector_within_the_bound)
{
    seeded_t seed = {0xDEADBEEFU};
    double worst = 0.0;

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const sincos_t direction = trig_sincos(seeded_u32(&seed));
        const sincos_t s = trig_sincos(seeded_u32(&seed));
        const ab_t v = {direction.cos, direction.sin};
        const ab_t r = transforms_park_inverse(transforms_park(v, s), s);

        worst = fmax(worst, fmax(abs(r.alpha - v.alpha), abs(r.beta - v.beta)));
    }
    figure_check("Park and back, LSB", worst, ROUND_TRIP_BOUND_LSB, ROUND_TRIP_SHARE);
}

TEST(test_square_of_a_length_is_exact_to_the_largest_vectors)
{
    TEST_ASSERT_EQUAL_HEX32(0U, transforms_square((dq_t){0, 0}));
    TEST_ASSERT_EQUAL_HEX32(25U, transforms_square((dq_t){3, -4}));
    TEST_ASSERT_EQUAL_HEX32(0x7FFE0002U, transforms_square((dq_t){32767, -32767}));
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, transforms_square((dq_t){-32768, -32768}));
}
