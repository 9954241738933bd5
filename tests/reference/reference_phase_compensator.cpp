// SPDX-License-Identifier: MIT
// Phase compensator beside its twin.
#include "firmware.h"
#include "settings_under_test.h"
#include "twin_phase_compensator.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Seeded;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;

// In units of 2^-32 turn. A sample adds g·α_r: α_r is within 2^15 (2^-17 turn) of the exact one, g
// times that; the product is rounded down twice, 1 + 2^-7. Nothing contracts it; the error of the
// arctangent changes its sign with the vector's direction. The twin's own sums of radians below 40
// round to 2^-48, 1e-5 of a unit.
static constexpr double ATAN_UNITS = 32768.0;
static constexpr double ROUNDING_UNITS = 1.0 + 1.0 / 128.0;

static constexpr double LEAST_SHARE = 0.01;

// g = 0.001, leads of −6° to 40°.
static const phase_compensator_cfg_t CFG = {16777, 8, 477218588, 71582788, 725};

static nf::twin::PhaseCompensator::Params twin_params()
{
    const double unit = TWO_PI / STEPS_PER_TURN;
    return {std::ldexp(CFG.gain, -16 - static_cast<int>(CFG.gain_shift)), CFG.lead_max * unit,
            CFG.brake_max * unit, static_cast<double>(CFG.current_min)};
}

static double gain()
{
    return twin_params().gain;
}

// A current that swings about the q axis, as after a load step, at any angle of a rotor that turns.
TEST(test_leads_stay_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 20000;
    for (const bool forwards : {true, false}) {
        Seeded seeded(forwards ? 1 : 2);
        const double direction = forwards ? 1 : -1;
        const step_t speed = forwards ? 17179869 : -17179869; // 1200 rpm, 2 pole pairs, 10 kHz
        phase_compensator_t comp;
        nf::twin::PhaseCompensator twin(twin_params());
        angle_t rotor = 0x12345678;
        double worst = 0;
        double limits = 0;

        phase_compensator_start(&comp, rotor);
        twin.start(rotor / STEPS_PER_TURN * TWO_PI);
        for (int k = 0; k < STEPS; k++) {
            const double swing = std::sin(k * 0.025);
            const dq_t current = {static_cast<int32_t>(std::lround(900 * swing)) +
                                      seeded.in(-40, 40),
                                  seeded.in(-3000, 3000)};
            const int32_t lead =
                phase_compensator_step(&comp, &CFG, current, rotor, speed, forwards);
            const double exact = twin.step(current.d, current.q, rotor / STEPS_PER_TURN * TWO_PI,
                                           speed / STEPS_PER_TURN * TWO_PI, direction) /
                                 TWO_PI * STEPS_PER_TURN;
            const bool limited = std::abs(lead) == CFG.lead_max || std::abs(lead) == CFG.brake_max;

            worst = std::max(worst, std::abs(lead - exact));
            limits += limited ? 1 : 0;
            rotor += static_cast<angle_t>(speed);
        }
        TEST_ASSERT_TRUE(limits < STEPS / 2.0);
        figure_check("phase compensator beside its twin, 2^-32 turn", worst,
                     STEPS * (gain() * ATAN_UNITS + ROUNDING_UNITS), LEAST_SHARE);
    }
}

// (43) takes i_d to 0 where (42) leaves a rest: the twin in a loop with a motor at constant speed
// and torque, for which i_d falls in proportion to the lead.
TEST(test_the_accumulated_angle_ends_without_i_d)
{
    constexpr double LEAD_RAD = 0.16;
    constexpr double I_Q = 3000;
    constexpr double SLOPE = 20000; // of i_d over the lead missing
    nf::twin::PhaseCompensator twin(twin_params());
    phase_compensator_t comp;
    double lead = 0;
    int32_t firmware_lead = 0;

    twin.start(0);
    phase_compensator_start(&comp, 0);
    for (int k = 0; k < 20000; k++) {
        const double unit = TWO_PI / STEPS_PER_TURN;
        lead = twin.step(SLOPE * (LEAD_RAD - lead), I_Q, 0, 0, 1);
        const auto d = static_cast<int32_t>(std::lround(SLOPE * (LEAD_RAD - firmware_lead * unit)));
        firmware_lead = phase_compensator_step(&comp, &CFG, {d, 3000}, 0, 0, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, LEAD_RAD, lead);
    // i_d is rounded to an LSB: half of one is not seen.
    TEST_ASSERT_DOUBLE_WITHIN(0.5 / SLOPE + 1e-6, LEAD_RAD,
                              firmware_lead * TWO_PI / STEPS_PER_TURN);
}
