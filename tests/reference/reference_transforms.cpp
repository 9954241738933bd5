// SPDX-License-Identifier: MIT
// Clarke and Park transforms beside their twins.
#include "firmware.h"
#include "settings_under_test.h"
#include "twin_transforms.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;
using nf::twin::Vector;

// Clarke: 18919 for 32768/√3 = 18918.613 on |a + 2b| ≤ 3·16383: 0.58; result rounding 0.5.
static constexpr double CLARKE_LSB = 1.081;

// Park at an angle, |v| ≤ 1: sine and cosine are 0.773 LSB off each at most, √2 of that in the
// product; their amplitude 32767 instead of 32768 costs 1 at full scale; result rounding 0.5.
static constexpr double PARK_LSB = 0.773 * 1.41422 + 1.0 + 0.5;

static constexpr double LEAST_SHARE = 0.4;
static constexpr int CASES = 200000;

static double radians(angle_t angle)
{
    return angle / STEPS_PER_TURN * TWO_PI;
}

TEST(test_clarke_stays_within_its_bound_of_the_twin)
{
    Seeded seeded(1);
    double worst = 0;

    for (int i = 0; i < CASES; i++) {
        const int32_t a = seeded.in(-16383, 16383);
        const int32_t b = seeded.in(-16383, 16383);
        const ab_t r = transforms_clarke(a, b);
        const Vector exact = nf::twin::clarke(a, b);

        worst = std::max({worst, std::abs(r.alpha - exact.x()), std::abs(r.beta - exact.y())});
    }
    figure_check("Clarke beside its twin, LSB", worst, CLARKE_LSB, LEAST_SHARE);
}

// A vector up to full scale in any direction.
static Vector seeded_vector(Seeded &seeded)
{
    const double radius = seeded.in(0, 32766);
    const double direction = seeded.in(0, 1 << 20) * TWO_PI / (1 << 20);
    const Vector v = nf::twin::park_inverse(Vector(radius, 0), direction);
    return {std::trunc(v.x()), std::trunc(v.y())};
}

TEST(test_park_stays_within_its_bound_of_the_twin)
{
    Seeded seeded(2);
    double worst = 0;

    for (int i = 0; i < CASES; i++) {
        const Vector v = seeded_vector(seeded);
        const auto angle = static_cast<angle_t>(seeded.in(INT32_MIN, INT32_MAX));
        const ab_t in = {static_cast<int32_t>(v.x()), static_cast<int32_t>(v.y())};
        const dq_t r = transforms_park(in, trig_sincos(angle));
        const Vector exact = nf::twin::park(v, radians(angle));

        worst = std::max({worst, std::abs(r.d - exact.x()), std::abs(r.q - exact.y())});
    }
    figure_check("Park beside its twin, LSB", worst, PARK_LSB, LEAST_SHARE);
}

TEST(test_inverse_park_stays_within_its_bound_of_the_twin)
{
    Seeded seeded(3);
    double worst = 0;

    for (int i = 0; i < CASES; i++) {
        const Vector v = seeded_vector(seeded);
        const auto angle = static_cast<angle_t>(seeded.in(INT32_MIN, INT32_MAX));
        const dq_t in = {static_cast<int32_t>(v.x()), static_cast<int32_t>(v.y())};
        const ab_t r = transforms_park_inverse(in, trig_sincos(angle));
        const Vector exact = nf::twin::park_inverse(v, radians(angle));

        worst = std::max({worst, std::abs(r.alpha - exact.x()), std::abs(r.beta - exact.y())});
    }
    figure_check("inverse Park beside its twin, LSB", worst, PARK_LSB, LEAST_SHARE);
}
