/* SPDX-License-Identifier: MIT */
/*
 * Signs of a fault: each beside what the drive knows, at its bounds. The slow period of the example
 * is 1 ms, 10 ticks.
 */
#include "config_guard.h"
#include "diagnosis.h"
#include "drive.h"
#include "example_cfg.h"
#include "fault_text.h"
#include "testing.h"

#include <string.h>

#define POLE_PAIRS (4U)
#define TICKS_PER_S (10000)
#define WHOLE_CURRENT (8192) /* current_max of the example */

static drive_cfg_t cfg;
static drive_t drive;

void setUp(void)
{
    cfg = example_drive_cfg();
    cfg.oscillation.lag_periods_q4 = 160U;
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    drive.scene.state = DRIVE_STATE_RUN;
    drive.scene.motoring = WHOLE_CURRENT;
    drive.fault.id = FAULT_OSCILLATION;
}

static bool has(fault_sign_t sign)
{
    return ((diagnosis_signs(&drive, POLE_PAIRS) >> (uint32_t)sign) & 1U) != 0U;
}

static step_t step_of_hz(double hz)
{
    return (step_t)(hz / TICKS_PER_S * 4294967296.0);
}

/* halves_max half-waves at this frequency. */
static void swing(double hz, int32_t amplitude)
{
    const double periods = cfg.oscillation.halves_max / (2.0 * hz) * TICKS_PER_S / cfg.slow_ticks;

    drive.watch.oscillation.span = (uint32_t)(periods + 0.5);
    drive.fault.value = amplitude;
}

static uint32_t sign_of(fault_sign_t sign)
{
    return (uint32_t)1U << (uint32_t)sign;
}

/* Those of a swing alone. */
static uint32_t swing_signs_of(uint32_t pole_pairs)
{
    const uint32_t swing_has = sign_of(FAULT_SIGN_SHAFT) | sign_of(FAULT_SIGN_ELECTRIC) |
                               sign_of(FAULT_SIGN_SHAFT_OR_ELECTRIC) | sign_of(FAULT_SIGN_SIX) |
                               sign_of(FAULT_SIGN_LAG);

    return diagnosis_signs(&drive, pole_pairs) & swing_has;
}

static void assert_swing(double hz, int32_t amplitude, fault_sign_t only)
{
    static const fault_sign_t all[] = {FAULT_SIGN_SHAFT, FAULT_SIGN_ELECTRIC,
                                       FAULT_SIGN_SHAFT_OR_ELECTRIC, FAULT_SIGN_SIX,
                                       FAULT_SIGN_LAG};

    swing(hz, amplitude);
    for (uint32_t k = 0U; k < (sizeof(all) / sizeof(all[0])); k++) {
        TEST_ASSERT_EQUAL(all[k] == only, has(all[k]));
    }
}

/*
 * The shaft turns 3 times a second, 12 electrical turns. The loop has a phase lag of 180° at
 * 100 Hz: 16·10 sixteenths of 1 ms.
 */
TEST(test_each_swing_has_the_sign_of_its_frequency)
{
    drive.motion.speed_loop.reference = -step_of_hz(12.0);
    assert_swing(3.0, 2000, FAULT_SIGN_SHAFT);
    assert_swing(6.2, 2000, FAULT_SIGN_SHAFT);
    assert_swing(1.5, 2000, FAULT_SIGN_SHAFT);
    assert_swing(8.8, 2000, FAULT_SIGN_SHAFT);
    assert_swing(4.5, 2000, FAULT_SIGN_NONE);
    assert_swing(12.0, 2000, FAULT_SIGN_ELECTRIC);
    assert_swing(23.0, 2000, FAULT_SIGN_ELECTRIC);
    assert_swing(10.4, 2000, FAULT_SIGN_NONE);
    assert_swing(95.0, 2000, FAULT_SIGN_LAG);
    assert_swing(130.0, 2000, FAULT_SIGN_LAG);
    assert_swing(50.0, 2000, FAULT_SIGN_NONE);
    assert_swing(150.0, 2000, FAULT_SIGN_NONE);
    drive.motion.speed_loop.reference = step_of_hz(8.0);
    assert_swing(48.0, 2000, FAULT_SIGN_SIX);
}

/*
 * With three pole pairs a third harmonic of the shaft is once an electrical turn, with one all are
 * the same.
 */
TEST(test_with_few_pole_pairs_a_swing_has_two_causes)
{
    drive.motion.speed_loop.reference = step_of_hz(12.0);
    swing(12.0, 2000);
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_SHAFT_OR_ELECTRIC), swing_signs_of(3U));
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_SHAFT_OR_ELECTRIC), swing_signs_of(2U));
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_SHAFT_OR_ELECTRIC), swing_signs_of(1U));
    swing(6.0, 2000);
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_SHAFT), swing_signs_of(2U));
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_SHAFT), swing_signs_of(1U));
    swing(24.0, 2000);
    TEST_ASSERT_EQUAL_UINT32(sign_of(FAULT_SIGN_ELECTRIC), swing_signs_of(2U));
}

/*
 * A load at 80 Hz that the loop answers to is below the limit; a loop that swings by itself is at
 * it, whatever turns as fast.
 */
TEST(test_a_swing_at_the_limit_of_the_current_is_the_loops_own)
{
    drive.motion.speed_loop.reference = step_of_hz(320.0);
    swing(80.0, 4000);
    TEST_ASSERT_TRUE(has(FAULT_SIGN_SHAFT));
    swing(80.0, WHOLE_CURRENT);
    TEST_ASSERT_FALSE(has(FAULT_SIGN_SHAFT));
    TEST_ASSERT_TRUE(has(FAULT_SIGN_LAG));
}

TEST(test_without_a_swing_there_is_no_sign_of_one)
{
    drive.motion.speed_loop.reference = 0;
    drive.watch.oscillation.span = 0U;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_SHAFT));
    TEST_ASSERT_FALSE(has(FAULT_SIGN_ELECTRIC));
    TEST_ASSERT_FALSE(has(FAULT_SIGN_LAG));
    cfg.oscillation.lag_periods_q4 = 0U; /* nothing is faster than such a loop */
    drive.motion.speed_loop.reference = step_of_hz(12.0);
    TEST_ASSERT_FALSE(has(FAULT_SIGN_SHAFT));
    TEST_ASSERT_FALSE(has(FAULT_SIGN_ELECTRIC));
    drive.watch.oscillation.halves = 3U;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_SWING));
    drive.watch.oscillation.halves = 4U;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_SWING));
}

TEST(test_a_derated_torque_is_a_sign_in_RUN_where_a_quarter_of_it_is_gone)
{
    drive.scene.limits = DERATING_BUS_LOW;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_DERATED_BUS));
    drive.scene.motoring = (3 * WHOLE_CURRENT / 4) - 1;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_DERATED_BUS));
    TEST_ASSERT_FALSE(has(FAULT_SIGN_DERATED_OTHER));
    drive.scene.limits = DERATING_TEMPERATURE;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_DERATED_OTHER));
    drive.scene.state = DRIVE_STATE_HOLD;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_DERATED_OTHER));
}

/* 100 samples of both sensors whose neighbours differ by `counts` in the mean. */
static void noise(int32_t counts)
{
    drive.sensors.sums.samples = 100U;
    drive.sensors.sums.noise = 200 * counts;
}

TEST(test_noise_at_rest_is_told_beside_the_limit_of_the_start)
{
    const int32_t lsb = (int32_t)(1UL << cfg.sampling.current_shift);
    const int32_t enough = (cfg.startup.residual_max / (6 * lsb)) + 1;

    noise(enough - 1);
    TEST_ASSERT_FALSE(has(FAULT_SIGN_NOISE));
    noise(enough);
    TEST_ASSERT_TRUE(has(FAULT_SIGN_NOISE));
    drive.fault.id = FAULT_STARTUP;
    TEST_ASSERT_NOT_NULL(strstr(diagnosis_advice(&drive, POLE_PAIRS), "noisy"));
}

TEST(test_a_torque_against_the_speed_brakes_and_ripple_does_not)
{
    drive.scene.speed = -1000000;
    drive.scene.torque = cfg.supervision.phase_range_min;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_BRAKES));
    drive.scene.torque++;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_BRAKES));
    drive.scene.torque = 0;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_BRAKES));
    drive.scene.limits = DERATING_BUS_HIGH;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_BRAKES));
    drive.scene.torque = -cfg.supervision.phase_range_min; /* with the speed: it drives */
    TEST_ASSERT_FALSE(has(FAULT_SIGN_BRAKES));
}

TEST(test_a_rotor_follows_the_vector_of_a_start_with_half_of_its_speed)
{
    drive.scene.state = DRIVE_STATE_HANDOVER;
    drive.vector.step = 1000000;
    drive.rotor.observer.speed = 500000;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_NOT_FOLLOWED));
    drive.rotor.observer.speed = 499999;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_NOT_FOLLOWED));
    TEST_ASSERT_TRUE(has(FAULT_SIGN_START));
    drive.scene.state = DRIVE_STATE_RUN;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_NOT_FOLLOWED));
}

/*
 * The cold end is the low one where the counts rise with the temperature, and the high one where
 * they fall.
 */
TEST(test_an_open_thermistor_is_at_the_cold_end_whichever_side_that_is)
{
    cfg.derating.temperature_lowest = 60;
    cfg.derating.temperature_highest = 4000;
    drive.fault.value = 10;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_COLD));
    cfg.derating.temperature.gain = -cfg.derating.temperature.gain;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_COLD));
    drive.fault.value = 4090;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_COLD));
}

TEST(test_a_phase_that_keeps_its_value_while_the_other_moves_is_stuck)
{
    drive.watch.supervision.highest[0] = 500;
    drive.watch.supervision.lowest[0] = 500;
    drive.watch.supervision.highest[1] = cfg.supervision.phase_range_min;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_STUCK));
    drive.watch.supervision.highest[1]++;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_STUCK));
    drive.watch.supervision.highest[0] = 502;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_STUCK));
}

TEST(test_a_phase_without_current_is_told_of_each_of_the_three)
{
    const int32_t zero = cfg.supervision.phase_zero_max;

    drive.scene.phase_a = zero + 1;
    drive.scene.phase_b = 5000;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_NO_CURRENT));
    drive.scene.phase_a = -zero;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_NO_CURRENT));
    drive.scene.phase_a = -5000;
    TEST_ASSERT_TRUE(has(FAULT_SIGN_NO_CURRENT));
    drive.scene.state = DRIVE_STATE_READY;
    TEST_ASSERT_FALSE(has(FAULT_SIGN_NO_CURRENT));
}
