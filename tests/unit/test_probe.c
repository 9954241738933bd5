/* SPDX-License-Identifier: MIT */
/* The probe: what its words set, what it sums up, how its vector turns, and the pulses. */
#include "probe.h"

#include "unity.h"

#define SPEED_MAX (0x20000000)

static probe_t probe;

void setUp(void)
{
    probe_reset(&probe);
}

void tearDown(void)
{
}

static const probe_sample_t SAMPLE = {
    .phase_a = 100,
    .phase_b = -40,
    .current = {.d = 90, .q = -7},
    .voltage = {.d = 500, .q = -300},
    .bus = 22000,
};

static void note_times(const probe_sample_t *sample, uint32_t times)
{
    for (uint32_t k = 0U; k < times; k++) {
        probe_note(&probe, sample);
    }
}

static void test_reset_leaves_no_current_no_window_and_gains_of_zero(void)
{
    TEST_ASSERT_EQUAL_INT32(0, probe.current);
    TEST_ASSERT_EQUAL_INT32(0, probe.loop.pi_d.kp);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.loop.pi_d.kp_shift);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.loop.pi_d.ki_shift);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.loop.pi_q.kp_shift);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.loop.pi_q.ki_shift);
    TEST_ASSERT_EQUAL_INT32(1, probe.pulse_ticks);
    TEST_ASSERT_EQUAL_INT32(1, probe.emf_full);
    TEST_ASSERT_EQUAL_UINT32(0U, probe.tick);
    TEST_ASSERT_FALSE(probe_pulses(&probe));
}

/* A word, the field it sets, and its range. */
static void assert_limited(probe_word_t word, const int32_t *field, int32_t lowest, int32_t highest)
{
    probe_set(&probe, (uint32_t)word, highest);
    TEST_ASSERT_EQUAL_INT32(highest, *field);
    probe_set(&probe, (uint32_t)word, lowest);
    TEST_ASSERT_EQUAL_INT32(lowest, *field);
    probe_set(&probe, (uint32_t)word, INT32_MAX);
    TEST_ASSERT_EQUAL_INT32(highest, *field);
    probe_set(&probe, (uint32_t)word, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(lowest, *field);
}

static void test_words_are_limited_to_their_range(void)
{
    assert_limited(PROBE_CURRENT, &probe.current, 0, 16383);
    assert_limited(PROBE_RATE, &probe.rate, 0, SPEED_MAX);
    assert_limited(PROBE_RAMP, &probe.ramp, 0, SPEED_MAX);
    assert_limited(PROBE_SPEED, &probe.speed, -SPEED_MAX, SPEED_MAX);
    assert_limited(PROBE_DAMPING, &probe.damping, 0, SPEED_MAX);
    assert_limited(PROBE_TRACKING, &probe.tracking, 0, SPEED_MAX);
    assert_limited(PROBE_RESISTANCE, &probe.loop.resistance_q13, 0, 32767);
    assert_limited(PROBE_LOSS, &probe.loss, 0, 32767);
    assert_limited(PROBE_EMF, &probe.emf_full, 1, 32767);
    assert_limited(PROBE_PULSE_D, &probe.pulse.d, 0, 32767);
    assert_limited(PROBE_PULSE_Q, &probe.pulse.q, 0, 32767);
    assert_limited(PROBE_PULSE_TICKS, &probe.pulse_ticks, 1, 64);
    assert_limited(PROBE_REACTANCE, &probe.loop.reactance_d_q13, 0, 32767);
    probe_set(&probe, (uint32_t)PROBE_REACTANCE, 77);
    TEST_ASSERT_EQUAL_INT32(77, probe.loop.reactance_d_q13);
    TEST_ASSERT_EQUAL_INT32(77, probe.loop.reactance_q_q13);
}

static void test_an_angle_is_any_word(void)
{
    probe_set(&probe, (uint32_t)PROBE_ANGLE, -5);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFFFFBU, probe.angle);
}

static int32_t gain(uint32_t mantissa, uint32_t shift)
{
    return (int32_t)((shift << 16U) | mantissa);
}

static void test_a_gain_has_a_mantissa_and_a_shift_of_1_to_30(void)
{
    probe_set(&probe, (uint32_t)PROBE_GAIN_D, gain(32767U, 7U));
    probe_set(&probe, (uint32_t)PROBE_GAIN_Q, gain(5U, 40U));
    probe_set(&probe, (uint32_t)PROBE_INTEGRAL_D, gain(6U, 0U));
    probe_set(&probe, (uint32_t)PROBE_INTEGRAL_Q, gain(0x8001U, 30U));
    TEST_ASSERT_EQUAL_INT32(32767, probe.loop.pi_d.kp);
    TEST_ASSERT_EQUAL_UINT32(7U, probe.loop.pi_d.kp_shift);
    TEST_ASSERT_EQUAL_INT32(5, probe.loop.pi_q.kp);
    TEST_ASSERT_EQUAL_UINT32(30U, probe.loop.pi_q.kp_shift);
    TEST_ASSERT_EQUAL_INT32(6, probe.loop.pi_d.ki);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.loop.pi_d.ki_shift);
    TEST_ASSERT_EQUAL_INT32(1, probe.loop.pi_q.ki); /* 15 bits of mantissa */
    TEST_ASSERT_EQUAL_UINT32(30U, probe.loop.pi_q.ki_shift);
}

static void test_a_word_of_the_motion_loops_changes_nothing(void)
{
    const probe_t before = probe;

    probe_set(&probe, 0U, 1000);
    probe_set(&probe, 1U, 1000);
    probe_set(&probe, (uint32_t)PROBE_CURRENT - 1U, 1000);
    probe_set(&probe, (uint32_t)PROBE_WORDS, 1000);
    probe_set(&probe, 255U, 1000);
    TEST_ASSERT_EQUAL_MEMORY(&before, &probe, sizeof probe);
}

static void test_a_window_sums_so_many_samples_and_ends_two_ticks_later(void)
{
    const int32_t word = (3 << 20) | 10;

    probe_set(&probe, (uint32_t)PROBE_WINDOW, word);
    TEST_ASSERT_FALSE(probe_is_done(&probe, word));
    note_times(&SAMPLE, 11U);
    TEST_ASSERT_FALSE(probe_is_done(&probe, word));
    note_times(&SAMPLE, 1U);
    TEST_ASSERT_TRUE(probe_is_done(&probe, word));
    TEST_ASSERT_FALSE(probe_is_done(&probe, word + 1));
    note_times(&SAMPLE, 5U);
    TEST_ASSERT_EQUAL_INT32(5000, probe.sums.voltage.d);
    TEST_ASSERT_EQUAL_INT32(-3000, probe.sums.voltage.q);
    TEST_ASSERT_EQUAL_INT32(900, probe.sums.current.d);
    TEST_ASSERT_EQUAL_INT32(-70, probe.sums.current.q);
    TEST_ASSERT_EQUAL_INT32(55000, probe.sums.bus);
    TEST_ASSERT_EQUAL_INT32(7, probe.sums.across);
    TEST_ASSERT_EQUAL_INT32(100, probe.sums.noise_a); /* the first sample against none before */
    TEST_ASSERT_EQUAL_INT32(40, probe.sums.noise_b);
}

static void test_noise_is_the_change_from_sample_to_sample(void)
{
    probe_sample_t high = SAMPLE;

    high.phase_a = 104;
    high.phase_b = -43;
    note_times(&SAMPLE, 1U);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 4);
    for (uint32_t k = 0U; k < 2U; k++) {
        probe_note(&probe, &high);
        probe_note(&probe, &SAMPLE);
    }
    TEST_ASSERT_EQUAL_INT32(16, probe.sums.noise_a);
    TEST_ASSERT_EQUAL_INT32(12, probe.sums.noise_b);
}

static void test_a_window_opens_once_for_its_word_and_begins_from_nothing(void)
{
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 2);
    note_times(&SAMPLE, 4U);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 2);
    TEST_ASSERT_EQUAL_UINT32(0U, probe.tick);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, (1 << 20) | 2);
    TEST_ASSERT_EQUAL_UINT32(1U, probe.tick);
    note_times(&SAMPLE, 4U);
    TEST_ASSERT_EQUAL_INT32(1000, probe.sums.voltage.d);
}

static void test_a_window_has_1_to_131071_ticks(void)
{
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 7 << 20);
    note_times(&SAMPLE, 3U);
    TEST_ASSERT_EQUAL_UINT32(0U, probe.tick);
    TEST_ASSERT_EQUAL_INT32(500, probe.sums.voltage.d);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, (8 << 20) | 0xFFFFF);
    note_times(&SAMPLE, 131072U);
    TEST_ASSERT_EQUAL_UINT32(131073U, probe.tick);
    note_times(&SAMPLE, 1U);
    TEST_ASSERT_EQUAL_UINT32(0U, probe.tick);
    TEST_ASSERT_EQUAL_INT32(131071 * 90, probe.sums.current.d);
}

static void test_sums_stop_short_of_32_bits(void)
{
    probe_sample_t large = SAMPLE;

    large.voltage = (dq_t){32767, -32768};
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 100000);
    note_times(&large, 100000U);
    TEST_ASSERT_EQUAL_INT32(0x7FFE0000 + 32767, probe.sums.voltage.d);
    TEST_ASSERT_EQUAL_INT32(-0x7FFE0000 - 32768, probe.sums.voltage.q);
}

static void test_the_turn_of_the_vector_wraps(void)
{
    probe_sample_t sample = SAMPLE;

    probe_set(&probe, (uint32_t)PROBE_WINDOW, 3);
    sample.turns_q16 = INT32_MAX - 1;
    probe_note(&probe, &sample);
    TEST_ASSERT_EQUAL_INT32(0, probe.sums.turn_q16);
    sample.turns_q16 = INT32_MIN + 3;
    probe_note(&probe, &sample);
    TEST_ASSERT_EQUAL_INT32(5, probe.sums.turn_q16);
}

static void test_a_turn_is_that_of_all_samples_of_the_window(void)
{
    probe_sample_t sample = SAMPLE;

    probe_set(&probe, (uint32_t)PROBE_WINDOW, 4);
    for (int32_t k = 0; k < 8; k++) {
        sample.turns_q16 = 100 * k;
        probe_note(&probe, &sample);
    }
    TEST_ASSERT_EQUAL_INT32(500, probe.sums.turn_q16); /* to the last of 6 */
}

/* e·i/ω in Q15: 1000·300 + 200·30 over 2000, at a loss of 50 with a current. */
static void test_torque_is_the_power_of_the_emf_over_the_speed(void)
{
    probe_sample_t sample = SAMPLE;

    sample.current = (dq_t){300, 30};
    sample.emf = (dq_t){1050, 200};
    sample.speed_q15 = 2000;
    probe_set(&probe, (uint32_t)PROBE_LOSS, 50);
    probe_set(&probe, (uint32_t)PROBE_CURRENT, 1);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 2);
    note_times(&sample, 4U);
    TEST_ASSERT_EQUAL_INT32(2 * 153, probe.sums.torque);
}

static void assert_torque(int32_t expected, int32_t emf_d, int32_t speed_q15)
{
    probe_sample_t sample = SAMPLE;

    setUp();
    sample.current = (dq_t){1, 0};
    sample.emf = (dq_t){emf_d, 0};
    sample.speed_q15 = speed_q15;
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 1);
    probe_note(&probe, &sample);
    TEST_ASSERT_EQUAL_INT32(expected, probe.sums.torque);
}

static void test_torque_is_rounded_to_the_nearest_in_all_signs(void)
{
    assert_torque(2, 15, 10);
    assert_torque(2, 15, 9);
    assert_torque(1, 14, 10);
    assert_torque(-2, -15, 10);
    assert_torque(-1, -14, 10);
    assert_torque(-2, 15, -10);
    assert_torque(2, -15, -10);
    assert_torque(0, 4, 10);
    assert_torque(0, 15, 0);
}

static void test_torque_without_a_current_has_no_loss(void)
{
    probe_set(&probe, (uint32_t)PROBE_LOSS, 50);
    {
        probe_sample_t sample = SAMPLE;

        sample.current = (dq_t){10, 0};
        sample.emf = (dq_t){100, 0};
        sample.speed_q15 = 1;
        probe_set(&probe, (uint32_t)PROBE_WINDOW, 1);
        probe_note(&probe, &sample);
    }
    TEST_ASSERT_EQUAL_INT32(1000, probe.sums.torque);
}

static void test_torque_saturates(void)
{
    assert_torque(32767, 40000, 1);
    assert_torque(-32768, -40000, 1);
}

/* The voltage of each tick of a window with pulses, as the drive asks for it. */
static dq_t next_voltage(dq_t steady)
{
    probe_note(&probe, &SAMPLE);
    return probe_pulses(&probe) ? probe_voltage(&probe, steady) : steady;
}

static void test_pulses_are_plus_minus_minus_plus_on_the_voltage_that_was_there(void)
{
    static const int32_t signs[] = {1, 1, -1, -1, -1, -1, 1, 1, 1, 1, -1, -1, -1, -1, 1, 1};

    probe_set(&probe, (uint32_t)PROBE_PULSE_Q, 700);
    probe_set(&probe, (uint32_t)PROBE_PULSE_TICKS, 2);
    TEST_ASSERT_FALSE(probe_pulses(&probe));
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 16);
    for (int32_t k = 0; k < 16; k++) {
        const dq_t voltage = next_voltage((dq_t){40 + k, 60 - k});

        TEST_ASSERT_EQUAL_INT32(40, voltage.d);
        TEST_ASSERT_EQUAL_INT32(60 + (700 * signs[k]), voltage.q);
    }
    TEST_ASSERT_EQUAL_INT32(60, next_voltage((dq_t){40, 99}).q);
    TEST_ASSERT_EQUAL_INT32(99, next_voltage((dq_t){40, 99}).q); /* the window is over */
}

static void test_pulses_along_leave_the_voltage_across(void)
{
    probe_set(&probe, (uint32_t)PROBE_PULSE_D, 700);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 4);
    {
        const dq_t voltage = next_voltage((dq_t){40, 60});

        TEST_ASSERT_EQUAL_INT32(740, voltage.d);
        TEST_ASSERT_EQUAL_INT32(60, voltage.q);
    }
}

static void test_the_voltage_of_pulses_saturates(void)
{
    probe_set(&probe, (uint32_t)PROBE_PULSE_D, 32767);
    probe_set(&probe, (uint32_t)PROBE_PULSE_Q, 32767);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 4);
    {
        const dq_t first = next_voltage((dq_t){40000, 100});
        const dq_t second = next_voltage((dq_t){0, 0});

        TEST_ASSERT_EQUAL_INT32(32767, first.d);
        TEST_ASSERT_EQUAL_INT32(32767, first.q);
        TEST_ASSERT_EQUAL_INT32(0, second.d); /* 32767 held, less as much */
        TEST_ASSERT_EQUAL_INT32(100 - 32767, second.q);
    }
    probe_set(&probe, (uint32_t)PROBE_WINDOW, (1 << 20) | 4);
    {
        (void)next_voltage((dq_t){-40000, -100});
        const dq_t second = next_voltage((dq_t){0, 0});

        TEST_ASSERT_EQUAL_INT32(-32767, second.d);
        TEST_ASSERT_EQUAL_INT32(-32767, second.q);
    }
}

/* A current that answers to the pulses two ticks later: +5, −5, −5, +5 along, and three times as much across. */
static void test_changes_count_with_the_sign_of_the_pulse_two_ticks_before(void)
{
    static const int32_t along[] = {80, 80, 85, 80, 75, 80, 85, 80, 75, 80};
    probe_sample_t sample = SAMPLE;

    probe_set(&probe, (uint32_t)PROBE_PULSE_D, 700);
    sample.current = (dq_t){70, 210};
    probe_note(&probe, &sample);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 8);
    for (uint32_t k = 0U; k < 10U; k++) {
        sample.current = (dq_t){along[k], 3 * along[k]};
        probe_note(&probe, &sample);
    }
    TEST_ASSERT_EQUAL_INT32(8 * 5, probe.sums.change.d);
    TEST_ASSERT_EQUAL_INT32(8 * 15, probe.sums.change.q);
    TEST_ASSERT_EQUAL_INT32(0, probe.sums.carried);
}

/* The one tick of a pulse begins with the second sample and ends with the third. */
static void assert_carried(int32_t expected, probe_word_t pulse)
{
    static const dq_t currents[] = {{1, 10}, {2, 20}, {4, 40}};
    probe_sample_t sample = SAMPLE;

    setUp();
    probe_set(&probe, (uint32_t)pulse, 700);
    probe_set(&probe, (uint32_t)PROBE_WINDOW, 1);
    for (uint32_t k = 0U; k < 3U; k++) {
        sample.current = currents[k];
        probe_note(&probe, &sample);
    }
    TEST_ASSERT_EQUAL_INT32(expected, probe.sums.carried);
}

static void test_the_current_that_is_carried_is_that_along_the_pulse(void)
{
    assert_carried(6, PROBE_PULSE_D);
    assert_carried(60, PROBE_PULSE_Q);
}

static void test_a_vector_at_rest_goes_to_its_angle_the_short_way(void)
{
    probe_set(&probe, (uint32_t)PROBE_RATE, 1000);
    probe_set(&probe, (uint32_t)PROBE_ANGLE, -300);
    TEST_ASSERT_EQUAL_INT32(-300, probe_turn(&probe, 0U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(0, probe_turn(&probe, 0xFFFFFED4U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(-1000, probe_turn(&probe, 100000U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(1000, probe_turn(&probe, 0x90000000U, (dq_t){0, 0}));
}

static void test_the_speed_changes_by_its_ramp(void)
{
    probe_set(&probe, (uint32_t)PROBE_RAMP, 40);
    probe_set(&probe, (uint32_t)PROBE_SPEED, -100);
    TEST_ASSERT_EQUAL_INT32(-40, probe_turn(&probe, 0U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(-80, probe_turn(&probe, 0U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(-100, probe_turn(&probe, 0U, (dq_t){0, 0}));
    probe_set(&probe, (uint32_t)PROBE_SPEED, 0);
    probe_set(&probe, (uint32_t)PROBE_RATE, 9);
    TEST_ASSERT_EQUAL_INT32(-60, probe_turn(&probe, 5U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(-20, probe_turn(&probe, 5U, (dq_t){0, 0}));
    TEST_ASSERT_EQUAL_INT32(-5, probe_turn(&probe, 5U, (dq_t){0, 0}));
}

/* At a constant speed of 1000 and with this damping, 2·K. */
static void turn_at(step_t speed, step_t damping)
{
    setUp();
    probe_set(&probe, (uint32_t)PROBE_RAMP, SPEED_MAX);
    probe_set(&probe, (uint32_t)PROBE_SPEED, speed);
    probe_set(&probe, (uint32_t)PROBE_DAMPING, damping);
}

/* e = (3000, 4000): sin δ = 0.6, in Q15 19660.2. K·sin δ = 65536/2·0.6. */
static void test_damping_takes_off_the_speed_in_proportion_to_the_lag(void)
{
    turn_at(1000000, 65536);
    TEST_ASSERT_EQUAL_INT32(1000000 - 19660, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
    TEST_ASSERT_EQUAL_INT32(19660, probe.lag_q15);
    turn_at(1000000, 65536);
    TEST_ASSERT_EQUAL_INT32(1000000 + 19660, probe_turn(&probe, 0U, (dq_t){-3000, 4000}));
    turn_at(-1000000, 65536);
    TEST_ASSERT_EQUAL_INT32(-1000000 - 19660, probe_turn(&probe, 0U, (dq_t){-3000, -4000}));
    TEST_ASSERT_EQUAL_INT32(19660, probe.lag_q15);
}

/* After so many time constants of 1024 ticks that less than a step of 1/32768 is left: ln(19660) = 9.9. */
static void test_damping_leaves_a_constant_lag(void)
{
    turn_at(1000000, 65536);
    for (uint32_t k = 0U; k < (11U * 1024U); k++) {
        (void)probe_turn(&probe, 0U, (dq_t){3000, 4000});
    }
    TEST_ASSERT_INT32_WITHIN(1, 1000000, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
    TEST_ASSERT_EQUAL_INT32(1000000 + 19660, probe_turn(&probe, 0U, (dq_t){0, 4000}));
}

/* After one time constant 1/e of it is left. */
static void test_the_mean_of_the_lag_is_over_1024_ticks(void)
{
    turn_at(1000000, 65536);
    for (uint32_t k = 0U; k < 1024U; k++) {
        (void)probe_turn(&probe, 0U, (dq_t){3000, 4000});
    }
    TEST_ASSERT_INT32_WITHIN(20, 1000000 - 7233, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
}

static void test_damping_never_turns_the_vector_back(void)
{
    turn_at(1000, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(500, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
    turn_at(-1000, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(-1500, probe_turn(&probe, 0U, (dq_t){-3000, -4000}));
}

static void test_a_damped_speed_stays_within_its_range(void)
{
    turn_at(SPEED_MAX, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(SPEED_MAX, probe_turn(&probe, 0U, (dq_t){-3000, 4000}));
    turn_at(-SPEED_MAX, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(-SPEED_MAX, probe_turn(&probe, 0U, (dq_t){-3000, -4000}));
}

static void test_what_the_legs_lose_is_no_lag(void)
{
    turn_at(1000000, 65536);
    probe_set(&probe, (uint32_t)PROBE_LOSS, 3000);
    probe_set(&probe, (uint32_t)PROBE_CURRENT, 1);
    TEST_ASSERT_EQUAL_INT32(1000000, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
}

/* e = (300, 400) where 1000 is needed: sin δ counts as 0.3. */
static void test_a_small_emf_counts_less(void)
{
    turn_at(1000000, 65536);
    probe_set(&probe, (uint32_t)PROBE_EMF, 1000);
    TEST_ASSERT_EQUAL_INT32(1000000 - 9830, probe_turn(&probe, 0U, (dq_t){300, 400}));
}

static void test_no_emf_is_no_lag(void)
{
    turn_at(1000000, 65536);
    TEST_ASSERT_EQUAL_INT32(1000000, probe_turn(&probe, 0U, (dq_t){0, 0}));
}

static void test_a_lag_saturates(void)
{
    turn_at(1000000, 65536);
    TEST_ASSERT_EQUAL_INT32(1000000 - 32767, probe_turn(&probe, 0U, (dq_t){100000, 0}));
}

/* 2·k = 65536 a tick: the speed itself falls, and no mean takes the lag off. */
static void test_tracking_moves_the_speed_itself(void)
{
    turn_at(1000000, 65536);
    probe_set(&probe, (uint32_t)PROBE_TRACKING, 65536);
    probe_set(&probe, (uint32_t)PROBE_RAMP, 0);
    probe.own_speed = 1000000;
    TEST_ASSERT_EQUAL_INT32(1000000 - 19660 - 19660, probe_turn(&probe, 0U, (dq_t){3000, 4000}));
    TEST_ASSERT_EQUAL_INT32(1000000 - 19660, probe.own_speed);
    TEST_ASSERT_EQUAL_INT32(1000000 - (3 * 19660), probe_turn(&probe, 0U, (dq_t){3000, 4000}));
}

static void test_a_tracked_speed_stays_within_its_range(void)
{
    turn_at(SPEED_MAX, 0);
    probe_set(&probe, (uint32_t)PROBE_TRACKING, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(SPEED_MAX, probe_turn(&probe, 0U, (dq_t){-3000, 4000}));
    turn_at(-SPEED_MAX, 0);
    probe_set(&probe, (uint32_t)PROBE_TRACKING, SPEED_MAX);
    TEST_ASSERT_EQUAL_INT32(-SPEED_MAX, probe_turn(&probe, 0U, (dq_t){-3000, -4000}));
}

static void test_at_rest_the_lag_is_forgotten(void)
{
    turn_at(1000, 65536);
    (void)probe_turn(&probe, 0U, (dq_t){3000, 4000});
    probe_set(&probe, (uint32_t)PROBE_SPEED, 0);
    (void)probe_turn(&probe, 0U, (dq_t){3000, 4000});
    TEST_ASSERT_EQUAL_INT32(0, probe.lag_q15);
    TEST_ASSERT_EQUAL_INT32(0, probe.mean_lag_q27);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reset_leaves_no_current_no_window_and_gains_of_zero);
    RUN_TEST(test_words_are_limited_to_their_range);
    RUN_TEST(test_an_angle_is_any_word);
    RUN_TEST(test_a_gain_has_a_mantissa_and_a_shift_of_1_to_30);
    RUN_TEST(test_a_word_of_the_motion_loops_changes_nothing);
    RUN_TEST(test_a_window_sums_so_many_samples_and_ends_two_ticks_later);
    RUN_TEST(test_noise_is_the_change_from_sample_to_sample);
    RUN_TEST(test_a_window_opens_once_for_its_word_and_begins_from_nothing);
    RUN_TEST(test_a_window_has_1_to_131071_ticks);
    RUN_TEST(test_sums_stop_short_of_32_bits);
    RUN_TEST(test_the_turn_of_the_vector_wraps);
    RUN_TEST(test_a_turn_is_that_of_all_samples_of_the_window);
    RUN_TEST(test_torque_is_the_power_of_the_emf_over_the_speed);
    RUN_TEST(test_torque_is_rounded_to_the_nearest_in_all_signs);
    RUN_TEST(test_torque_without_a_current_has_no_loss);
    RUN_TEST(test_torque_saturates);
    RUN_TEST(test_pulses_are_plus_minus_minus_plus_on_the_voltage_that_was_there);
    RUN_TEST(test_pulses_along_leave_the_voltage_across);
    RUN_TEST(test_the_voltage_of_pulses_saturates);
    RUN_TEST(test_changes_count_with_the_sign_of_the_pulse_two_ticks_before);
    RUN_TEST(test_the_current_that_is_carried_is_that_along_the_pulse);
    RUN_TEST(test_a_vector_at_rest_goes_to_its_angle_the_short_way);
    RUN_TEST(test_the_speed_changes_by_its_ramp);
    RUN_TEST(test_damping_takes_off_the_speed_in_proportion_to_the_lag);
    RUN_TEST(test_damping_leaves_a_constant_lag);
    RUN_TEST(test_the_mean_of_the_lag_is_over_1024_ticks);
    RUN_TEST(test_damping_never_turns_the_vector_back);
    RUN_TEST(test_a_damped_speed_stays_within_its_range);
    RUN_TEST(test_what_the_legs_lose_is_no_lag);
    RUN_TEST(test_a_small_emf_counts_less);
    RUN_TEST(test_no_emf_is_no_lag);
    RUN_TEST(test_a_lag_saturates);
    RUN_TEST(test_tracking_moves_the_speed_itself);
    RUN_TEST(test_a_tracked_speed_stays_within_its_range);
    RUN_TEST(test_at_rest_the_lag_is_forgotten);
    return UNITY_END();
}
