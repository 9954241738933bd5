// SPDX-License-Identifier: MIT
// Rotor position beside its twin: the integer integration is exact, so only the twin rounds.
#include "firmware.h"
#include "settings_under_test.h"
#include "twin_rotor_position.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Seeded;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;

static constexpr double PERIOD_S = 1e-4;
static constexpr int STEPS = 200000;

// The twin adds radians below 2π: half an ulp of 2^-51·… = 4.4e-16 rad for the sum, as much for T·ω
// and for the wrap; 1.3e-15 rad a step = 9.1e-7 units of 2^-32 turn, not contracted.
static constexpr double TWIN_UNITS_PER_STEP = 9.1e-7;

TEST(test_position_equals_the_twin_to_the_last_unit)
{
    Seeded seeded(1);
    rotor_position_t position;
    nf::twin::RotorPosition twin(PERIOD_S);
    double worst = 0;

    rotor_position_reset(&position, 0x12345678U);
    twin.reset(0x12345678 / STEPS_PER_TURN * TWO_PI);
    for (int k = 0; k < STEPS; k++) {
        const step_t step = seeded.in(-0x20000000, 0x20000000);

        rotor_position_step(&position, step);
        twin.step(step / STEPS_PER_TURN * TWO_PI / PERIOD_S);
        const double units = twin.angle_rad() / TWO_PI * STEPS_PER_TURN;
        const double difference = rotor_position_angle(&position) - units;
        worst = std::max(worst, std::abs(std::remainder(difference, STEPS_PER_TURN)));
    }
    const int64_t turns =
        (position.turns_q32 - rotor_position_angle(&position)) / (int64_t{1} << 32);
    TEST_ASSERT_EQUAL_INT64(twin.turns(), turns);
    TEST_ASSERT_TRUE(STEPS * TWIN_UNITS_PER_STEP < 0.5);
    // Its own roundings are random: their root of sum of squares is a small share of the worst
    // case.
    figure_check("position beside its twin, 2^-32 turn", worst, STEPS * TWIN_UNITS_PER_STEP, 1e-4);
}
