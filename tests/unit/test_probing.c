/* SPDX-License-Identifier: MIT */
/*
 * PROBE: when it begins and ends, what protects the drive in it, and what a motor shows of its
 * words.
 */
#include "driven_motor.h"
#include "fault_frames.h"
#include "instant.h"
#include "probing.h"
#include "seeded.h"
#include "testing.h"
#include "trig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SPEED_MAX (536870912) /* 2^29 */
#define STALE (77)
#define CURRENT (5504)   /* 6.719 A, continuous */
#define FLUX_WB (0.387)  /* of motor A */
#define CURRENT_A (40.0) /* I_b */
#define VOLTAGE_V (450.0)
#define SPEED_RAD (981.748)

void setUp(void)
{
    cfg = example_drive_cfg();
    power_on();
}

static void request(uint8_t what)
{
    in.command.request = what;
    tick();
}

static void begin(void)
{
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
}

static void word(probe_word_t which, int32_t value)
{
    in.command.mode = (uint8_t)which;
    in.command.target = value;
    tick();
}

/* With the gains of example_cfg.h, 500 Hz. */
static void begin_with(int32_t current)
{
    const int32_t proportional = (13 << 16) | 26537;
    const int32_t integral = (7 << 16) | 26678;

    begin();
    word(PROBE_GAIN_D, proportional);
    word(PROBE_GAIN_Q, proportional);
    word(PROBE_INTEGRAL_D, integral);
    word(PROBE_INTEGRAL_Q, integral);
    word(PROBE_RESISTANCE, 1547);
    word(PROBE_REACTANCE, 8293);
    word(PROBE_CURRENT, current);
}

static void turn(int32_t ramp, int32_t speed)
{
    word(PROBE_RAMP, ramp);
    word(PROBE_SPEED, speed);
}

/* ---- begin and end ---- */

TEST(test_probe_begins_when_it_is_asked_for_and_its_gates_are_on_from_the_next_tick)
{
    begin();
    assert_gates_open();
    tick();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
    TEST_ASSERT_TRUE(out.gate_enable);
}

TEST(test_the_request_to_run_wins)
{
    request(DRIVE_REQUEST_RUN | DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, drive.state);
    assert_gates_open();
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
}

TEST(test_probe_ends_with_open_gates_when_its_own_request_goes)
{
    static const uint8_t others[] = {0U, DRIVE_REQUEST_CLEAR, DRIVE_REQUEST_RUN};

    for (uint32_t k = 0U; k < 3U; k++) {
        setUp();
        begin();
        ticks(10U);
        request(DRIVE_REQUEST_PROBE | DRIVE_REQUEST_RUN);
        TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
        TEST_ASSERT_TRUE(out.gate_enable);
        request(others[k]);
        TEST_ASSERT_EQUAL(DRIVE_STATE_READY, drive.state);
        assert_gates_open();
    }
}

TEST(test_no_other_state_obeys_the_request_to_probe)
{
    cfg.sampling.offset_log2 = 4U;
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_OFFSET_CAL, drive.state);
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_OFFSET_CAL, drive.state);
    in.flags = DRIVE_FLAG_BREAK;
    request(DRIVE_REQUEST_PROBE);
    in.flags = 0U;
    request(DRIVE_REQUEST_PROBE);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    assert_gates_open();
}

TEST(test_it_begins_with_no_word_no_current_and_nothing_that_a_run_has_left)
{
    static const struct {
        const char *name;
        void *word; /* of 32 bits */
    } words[] = {
        {"attempts", &drive.start.attempts},
        {"late", &drive.watch.supervision.late},
        {"unexplained", &drive.watch.supervision.unexplained},
        {"halves", &drive.watch.oscillation.halves},
        {"step", &drive.vector.step},
        {"current_mean.d", &drive.vector.current_mean.d},
        {"current_mean.q", &drive.vector.current_mean.q},
        {"current_ref.d", &drive.control.current_ref.d},
        {"current_ref.q", &drive.control.current_ref.q},
        {"voltage.d", &drive.control.voltage.d},
        {"voltage.q", &drive.control.voltage.q},
        {"ratio_next.alpha", &drive.control.ratio_next.alpha},
        {"ratio_next.beta", &drive.control.ratio_next.beta},
        {"constant.d", &drive.control.current_loop.constant.d},
        {"constant.q", &drive.control.current_loop.constant.q},
        {"reactance.d", &drive.control.current_loop.reactance_q14.d},
        {"reactance.q", &drive.control.current_loop.reactance_q14.q},
        {"pi_d", &drive.control.current_loop.pi_d.integral_q26},
        {"pi_q", &drive.control.current_loop.pi_q.integral_q26},
    };
    static const int32_t stale = STALE;
    static const int32_t zero = 0;
    probe_t fresh;

    probe_reset(&fresh);
    memset(&drive.probe, 0x55, sizeof drive.probe);
    drive.vector.position.turns_q32 = STALE;
    for (size_t k = 0U; k < COUNT(words); k++) {
        memcpy(words[k].word, &stale, sizeof stale);
    }
    in.command.mode = (uint8_t)PROBE_CURRENT; /* of the first tick with a current */
    in.command.target = STALE;
    begin();
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &drive.probe, sizeof fresh);
    TEST_ASSERT_EQUAL_INT64(0, drive.vector.position.turns_q32);
    for (size_t k = 0U; k < COUNT(words); k++) {
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&zero, words[k].word, sizeof zero, words[k].name);
    }
}

/*
 * The current of a voltage drive is compared with its mean: the last run's is no reference of this
 * one.
 */
TEST(test_after_a_run_of_the_voltage_drive_no_current_is_missed)
{
    drive.voltage_drive.active = true;
    drive.voltage_drive.damping.mean_q30 = (dq_t){SPEED_MAX, SPEED_MAX};
    begin();
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    ticks(20000U);
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
}

/* ---- protection ---- */

TEST(test_each_fault_opens_the_gates_in_its_tick)
{
    for (uint32_t k = 0U; k < COUNT(FAULT_FRAMES); k++) {
        setUp();
        begin();
        ticks(10U);
        TEST_ASSERT_TRUE(out.gate_enable);
        FAULT_FRAMES[k].make(&in);
        drive_step(&drive, &in, &out);
        TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL(FAULT_FRAMES[k].id, drive.fault.id);
        assert_gates_open();
    }
}

/* A fault ends PROBE and opens the gates, which are on until then, in its tick. */
static void assert_ends_with(fault_id_t id)
{
    for (uint32_t k = 0U; (k < 2000U) && (drive.state == DRIVE_STATE_PROBE); k++) {
        TEST_ASSERT_TRUE(out.gate_enable);
        tick();
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL(id, drive.fault.id);
    assert_gates_open();
}

TEST(test_late_ticks_are_a_fault_as_ever)
{
    begin();
    tick();
    in.flags = DRIVE_FLAG_LATE;
    assert_ends_with(FAULT_LATE);
}

/* Found by the slow schedule, after the compare values are there. */
TEST(test_a_fault_of_the_slow_part_opens_the_gates_in_its_tick)
{
    begin();
    ticks(10U);
    in.adc_temperature = 4000U;
    assert_ends_with(FAULT_OVERTEMPERATURE);
}

/* A step of i²t in each round of the checks, as in RUN. */
static int32_t heating_with(int32_t current)
{
    int32_t before;

    word(PROBE_CURRENT, current);
    ticks(500U);
    before = drive.derating.heat_q24;
    ticks(4U * cfg.slow_ticks);
    return drive.derating.heat_q24 - before;
}

TEST(test_the_heat_of_the_imposed_current_is_counted)
{
    begin_with(CURRENT);
    TEST_ASSERT_GREATER_THAN_INT32(0, heating_with(CURRENT));
    TEST_ASSERT_LESS_THAN_INT32(0, heating_with(0));
}

/* ---- words ---- */

TEST(test_each_tick_gives_the_probe_its_word_and_nothing_else_is_one)
{
    begin();
    word(PROBE_CURRENT, 1234);
    TEST_ASSERT_EQUAL_INT32(1234, drive.probe.current);
    TEST_ASSERT_EQUAL_INT32(1234, drive.control.current_ref.d);
    TEST_ASSERT_EQUAL_INT32(0, drive.control.current_ref.q);
    word(PROBE_RATE, 55);
    TEST_ASSERT_EQUAL_INT32(1234, drive.probe.current);
    TEST_ASSERT_EQUAL_INT32(55, drive.probe.rate);
    word((probe_word_t)DRIVE_MODE_POSITION, 77);
    TEST_ASSERT_EQUAL_INT32(1234, drive.probe.current);
    TEST_ASSERT_EQUAL_INT32(55, drive.probe.rate);
}

/* Two windows begin in the ticks of their words: the sample of that tick is the first. */
TEST(test_the_sample_of_the_tick_with_its_word_is_the_first_of_a_window)
{
    begin();
    word(PROBE_WINDOW, 2);
    TEST_ASSERT_EQUAL_INT32(drive.bus / 4, drive.probe.sums.bus);
    ticks(2U);
    TEST_ASSERT_FALSE(probe_is_done(&drive.probe, 2));
    tick();
    TEST_ASSERT_TRUE(probe_is_done(&drive.probe, 2));
    TEST_ASSERT_EQUAL_INT32(2 * (drive.bus / 4), drive.probe.sums.bus);
}

static void assert_dq(dq_t expected, dq_t value)
{
    TEST_ASSERT_EQUAL_INT32(expected.d, value.d);
    TEST_ASSERT_EQUAL_INT32(expected.q, value.q);
}

TEST(test_the_samples_of_a_window_are_what_the_drive_has_measured)
{
    begin_with(CURRENT);
    turn(1000, (int32_t)(100.0 * STEPS_PER_RPM));
    ticks(50U);
    for (uint32_t k = 0U; k < 5U; k++) {
        const dq_t demanded = drive.control.voltage;
        const int32_t turns = (int32_t)(drive.vector.position.turns_q32 >> 16U);
        const sample_t before = instant_sample(&drive, &in);
        const angle_t angle = rotor_position_angle(&drive.vector.position);
        sample_t sample;

        word(PROBE_WINDOW, ((int32_t)(k + 1U) << PROBE_WINDOW_BITS) | 1);
        assert_dq(demanded, drive.probe.sums.voltage);
        sample = instant_sample(&drive, &in);
        assert_dq(
            transforms_park(transforms_clarke(sample.phase_a, sample.phase_b), trig_sincos(angle)),
            probing_current(&drive));
        assert_dq(probing_current(&drive), drive.probe.sums.current);
        TEST_ASSERT_EQUAL_INT32(abs(sample.phase_a - before.phase_a), drive.probe.sums.noise_a);
        TEST_ASSERT_EQUAL_INT32(abs(sample.phase_b - before.phase_b), drive.probe.sums.noise_b);
        TEST_ASSERT_EQUAL_INT32(turns, drive.probe.start_q16);
        ticks(2U);
    }
}

/* Along them it sees no error, and demands its integral, R·i* is 0; across there is no current. */
TEST(test_pulses_ride_on_what_the_control_demands_without_an_error)
{
    begin();
    word(PROBE_PULSE_D, 3000);
    pi_reset(&drive.control.current_loop.pi_d, 1000);
    pi_reset(&drive.control.current_loop.pi_q, -300);
    word(PROBE_WINDOW, 8);
    assert_dq((dq_t){1000 + 3000, -300}, drive.control.voltage);
}

/*
 * The voltage of the last demand less the model: R·i* of the plan; its reactances are 0. Torque:
 * e·i over the speed.
 */
TEST(test_the_emf_is_the_demand_less_what_the_model_needs)
{
    dq_t i;
    int32_t speed;

    begin();
    tick();
    turn(SPEED_MAX, 3000000);
    speed = 3000000 / 2048;
    in.adc_ia = MID_COUNTS + 300U;
    in.adc_ib = MID_COUNTS - 20U;
    in.command.mode = (uint8_t)PROBE_WINDOW;
    in.command.target = 1;
    drive.control.voltage = (dq_t){2000, -3000};
    drive.control.current_loop.constant = (dq_t){300, 400};
    drive_step(&drive, &in, &out);
    i = probing_current(&drive);
    TEST_ASSERT_TRUE((i.d != 0) && (i.q != 0));
    TEST_ASSERT_INT32_WITHIN(1, ((1700 * i.d) - (3400 * i.q)) / speed, drive.probe.sums.torque);
}

/* ---- the vector ---- */

TEST(test_the_vector_turns_with_its_speed_and_is_the_position)
{
    begin();
    turn(SPEED_MAX, 3000000);
    for (int64_t k = 1; k < 1000; k++) {
        TEST_ASSERT_EQUAL_INT64(3000000 * k, drive.vector.position.turns_q32);
        TEST_ASSERT_EQUAL_INT64(3000000 * k, drive.rotor.position.turns_q32);
        TEST_ASSERT_EQUAL_INT32(3000000, drive.vector.step);
        tick();
    }
    word(PROBE_ANGLE, 0x40000000);
    word(PROBE_RATE, SPEED_MAX);
    word(PROBE_SPEED, 0);
    ticks(10U);
    TEST_ASSERT_EQUAL_UINT32(0x40000000U, rotor_position_angle(&drive.vector.position));
    TEST_ASSERT_EQUAL_INT32(0, drive.vector.step);
}

/*
 * What the legs lose is to be measured: with a dead time in the configuration the compare values
 * are those without.
 */
TEST(test_dead_time_is_not_compensated_and_the_voltage_is_turned_for_its_period)
{
    cfg.modulator = example_modulator_cfg_with_dead_time();
    power_on();
    begin_with(CURRENT);
    turn(SPEED_MAX, 3000001);
    for (uint32_t k = 0U; k < 100U; k++) {
        const ab_t before = drive.control.ratio_next;
        const uint32_t middle =
            rotor_position_angle(&drive.vector.position) + 3000001U + (3000001U / 2U);
        dq_t ratio;
        ab_t expected;
        compare_t plain;

        tick();
        ratio = modulator_ratio(&drive.modulator, drive.control.voltage);
        expected = transforms_park_inverse(ratio, trig_sincos(middle));
        modulator_compare(&cfg.modulator, expected, &plain);
        TEST_ASSERT_EQUAL_MEMORY(&expected, &drive.control.ratio_next, sizeof expected);
        TEST_ASSERT_EQUAL_MEMORY(&before, &drive.control.ratio_acting, sizeof before);
        TEST_ASSERT_EQUAL_MEMORY(&plain, &out.compare, sizeof plain);
    }
}

/* ---- a motor ---- */

/* The converter has 8 LSB a count; the integral holds its mean to that. */
TEST(test_the_current_becomes_what_its_word_says_and_the_rotor_rests_on_it)
{
    begin_with(CURRENT);
    ticks(2000U);
    TEST_ASSERT_INT32_WITHIN(16, CURRENT, probing_current(&drive).d);
    TEST_ASSERT_INT32_WITHIN(16, 0, probing_current(&drive).q);
    /* R·i, to the step of the voltage over R: 1547/8192 */
    TEST_ASSERT_INT32_WITHIN(8, (CURRENT * 1547) / 8192, drive.control.voltage.d);
}

/* L·di/dt = v: Q15 of U_b a tick make so much of I_b, T/L·U_b/I_b. */
#define RISE (1e-4 / 0.0116 * 450.0 / 40.0)

TEST(test_along_pulses_the_control_holds_its_voltage)
{
    dq_t held;
    int32_t integral;

    begin_with(CURRENT / 2);
    ticks(2000U);
    word(PROBE_PULSE_D, 3000);
    word(PROBE_PULSE_TICKS, 4);
    held = drive.control.voltage;
    integral = drive.control.current_loop.pi_d.integral_q26;
    word(PROBE_WINDOW, 64);
    for (uint32_t k = 0U; k < 64U; k++) {
        const uint32_t quarter = (k / 4U) % 4U;
        const int32_t sign = ((quarter == 1U) || (quarter == 2U)) ? -1 : 1;

        TEST_ASSERT_INT32_WITHIN(32, held.d + (sign * 3000), drive.control.voltage.d);
        TEST_ASSERT_INT32_WITHIN(32, held.q, drive.control.voltage.q);
        TEST_ASSERT_EQUAL_INT32(integral, drive.control.current_loop.pi_d.integral_q26);
        tick();
    }
    TEST_ASSERT_INT32_WITHIN(32, held.d, drive.control.voltage.d);
    ticks(1U);
    TEST_ASSERT_TRUE(probe_is_done(&drive.probe, 64));
    TEST_ASSERT_TRUE(integral != drive.control.current_loop.pi_d.integral_q26);
    /*
     * R·t/L of a quarter is 0.073: to second order it takes 0.073²/2 a quarter; and a count of 8
     * LSB at both ends
     */
    TEST_ASSERT_INT32_WITHIN((int32_t)(64.0 * 3000.0 * RISE * 0.01) + 128,
                             (int32_t)lround(64.0 * 3000.0 * RISE), drive.probe.sums.change.d);
}

/*
 * A load holds the rotor back, by δ against the way it turns: T = 1.5·P·φ·i·sin δ, with the
 * friction of 0.001 Nm·s. The EMF at 300 rpm is 24.3 V: 1770 LSB, of which a count of each current
 * in R and L·ω takes up to 4, and Q13 of R and L another 1: 0.003 of sin δ. The torque is 3 % off
 * at most: 1 LSB of the sine of the frame, half a count in each current of 6.7 A, and the same EMF.
 */
TEST(test_a_load_shows_as_lag_and_torque_in_both_directions)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const double speed = 300.0 * EXAMPLE_PI / 30.0;
        const double torque = 2.0 + (0.001 * speed);
        const double share =
            torque / (1.5 * POLE_PAIRS * FLUX_WB * (CURRENT / 32768.0) * CURRENT_A);
        double found;

        setUp();
        begin_with(CURRENT);
        ticks(500U);
        word(PROBE_EMF, 300);
        word(PROBE_DAMPING, 20000000);
        turn(500, sign * (int32_t)(300.0 * STEPS_PER_RPM));
        ticks(15000U);
        load_nm = sign * 2.0;
        ticks(15000U);
        TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, drive.state);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, sign * share, drive.probe.lag_q15 / 32767.0);
        word(PROBE_WINDOW, 1000);
        ticks(1002U);
        TEST_ASSERT_TRUE(probe_is_done(&drive.probe, 1000));
        found = drive.probe.sums.torque / 1000.0 / 32768.0 * 1.5 * POLE_PAIRS * VOLTAGE_V *
                CURRENT_A / SPEED_RAD;
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * torque, sign * torque, found);
    }
}

/* ---- any words and frames ---- */

static void assert_in_range(void)
{
#define FREE(path, quantity)
#define FIELD(path, lowest, highest, quantity) \
    TEST_ASSERT_TRUE_MESSAGE(((int64_t)(drive.path) >= (int64_t)(lowest)) && \
                                 ((int64_t)(drive.path) <= (int64_t)(highest)), \
                             #path);
#include "state.def"
#undef FREE
#undef FIELD
}

static int32_t any_word(seeded_t *seed)
{
    const int32_t bits = seeded_in(seed, 0, 31);

    return seeded_i32(seed) >> bits;
}

TEST(test_any_words_and_samples_leave_each_field_in_its_range)
{
    seeded_t seed = {0x9B0B1U};
    uint32_t probing = 0U;

    example_supervise_nothing(&cfg);
    power_on();
    for (uint32_t k = 0U; k < 100000U; k++) {
        in.adc_ia = (uint16_t)(MID_COUNTS + (uint32_t)(seeded_in(&seed, 0, 1) * 700));
        in.adc_ib = (uint16_t)(MID_COUNTS - (uint32_t)(seeded_in(&seed, 0, 1) * 700));
        in.adc_bus = (uint16_t)seeded_in(&seed, 1830, 3600);
        in.command.mode = (uint8_t)seeded_in(&seed, 0, (int32_t)PROBE_WORDS);
        in.command.target = any_word(&seed);
        in.command.request =
            (seeded_in(&seed, 0, 9999) == 0) ? DRIVE_REQUEST_CLEAR : DRIVE_REQUEST_PROBE;
        drive_step(&drive, &in, &out);
        assert_in_range();
        probing += (drive.state == DRIVE_STATE_PROBE) ? 1U : 0U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(90000U, probing);
}
