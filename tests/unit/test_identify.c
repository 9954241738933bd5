/* SPDX-License-Identifier: MIT */
/* The identification's plans: what follows from the sums of an experiment; and how its words reach the drive. */
#include "example_app.h"
#include "identify.h"
#include "identify_aim.h"
#include "identify_rest.h"
#include "identify_turn.h"

#include <string.h>

static identify_t identify;
static text_t text;

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    (void)hal;
    (void)byte;
    return false;
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    (void)hal;
    (void)byte;
    return false;
}

static probe_sums_t *sums(void)
{
    return &app.drive.probe.sums;
}

void setUp(void)
{
    memset(&app, 0, sizeof app);
    power_on();
    calibrate();
    identify_init(&identify, &app, &ABOUT);
    identify.ms_ticks = 10;
    memset(&text, 0, sizeof text);
}

void tearDown(void)
{
}

static const char *said(void)
{
    memset(&text, 0, sizeof text);
    identify_step(&identify, &text);
    return text.characters;
}

/* Until it says something, with a tick before each pass. */
static const char *next_line(void)
{
    const char *line = said();

    for (uint32_t k = 0U; (k < 100000U) && (line[0] == '\0'); k++) {
        tick(1U);
        line = said();
    }
    return line;
}

static void assert_starts(const char *start, const char *line)
{
    TEST_ASSERT_EQUAL_STRING_LEN(start, line, strlen(start));
}

static void assert_refused(const char *why)
{
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NOT_NULL(identify.why);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(identify.why, why), identify.why);
}

/* ---- the run ---- */

static void test_it_starts_from_ready_only(void)
{
    app.drive.state = DRIVE_STATE_RUN;
    TEST_ASSERT_EQUAL_STRING("the drive is not READY", identify_start(&identify));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_STRING("", said());
}

/* 192/32768 of 40 A are 0.2344 A. */
static void test_a_current_that_the_converter_hardly_sees_is_refused_with_the_one_it_takes(void)
{
    cfg.derating.current_continuous = 191;
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_EQUAL_STRING(
        "identify refused: the continuous current of the name plate is too small for this board's "
        "sensors, it takes at least 0.235 A\r\n",
        said());
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    cfg.derating.current_continuous = 192;
    TEST_ASSERT_NULL(identify_start(&identify));
    assert_starts("identify 1 ", said());
}

static void test_it_says_its_scales_and_what_it_will_do(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_TRUE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_STRING("identify 1 100000000 20000000 450000000 2 11\r\n", said());
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
    assert_starts("pulses on each phase, the shaft hardly moves, up to ", next_line());
    assert_starts("= pulse 0 0 0 ", next_line());
    TEST_ASSERT_TRUE(app.out.gate_enable);
}

static void test_a_record_has_20_numbers(void)
{
    uint32_t spaces = 0U;

    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    (void)next_line();
    for (const char *c = next_line(); *c != '\0'; c++) {
        spaces += (*c == ' ') ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(21U, spaces);
}

static void test_stop_opens_the_gates(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    tick_period();
    identify_stop(&identify);
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_FALSE(app.out.gate_enable);
    TEST_ASSERT_EQUAL_STRING("", said());
}

static void test_a_stop_of_what_is_not_busy_stops_nothing(void)
{
    const drive_command_t run = {.request = DRIVE_REQUEST_RUN};

    command_mailbox_post(&app.mailbox, &run);
    identify_stop(&identify);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
}

static void test_a_fault_ends_it_with_a_line(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    tick_period();
    fail();
    TEST_ASSERT_EQUAL_STRING("identify refused: the drive has a fault: BREAK\r\n", said());
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
}

static void test_every_phase_is_said_before_it_begins(void)
{
    static const struct {
        identify_phase_t phase;
        const char *line;
    } phases[] = {
        {IDENTIFY_CATCH, "the shaft turns by up to one and a half electrical turns, with "},
        {IDENTIFY_STILL, "the shaft goes to three angles of an electrical turn, up to "},
        {IDENTIFY_SPIN, "the shaft turns, up to "},
        {IDENTIFY_RAMP, "between half of that speed and the whole"},
        {IDENTIFY_COAST, "no current, the shaft coasts"},
        {IDENTIFY_ENDS, "identify done\r\n"},
    };

    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    tick_period();
    for (uint32_t k = 0U; k < (sizeof phases / sizeof phases[0]); k++) {
        identify.phase = phases[k].phase;
        assert_starts(phases[k].line, said());
    }
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
}

static void test_noise_beyond_a_sixteenth_of_the_current_is_refused(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    /* ±a quarter of the range from sample to sample, and no current on average */
    for (uint32_t k = 0U; (k < 20000U) && identify_is_busy(&identify); k++) {
        measured.adc_ia = (uint16_t)(EXAMPLE_MIDDLE + ((k % 2U) * 300U));
        tick(1U);
        (void)said();
    }
    TEST_ASSERT_NOT_NULL(strstr(identify.why, "noise"));
}

static const char *line_with_current(identify_phase_t phase, uint32_t step, int32_t current)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    (void)next_line();
    identify.phase = phase;
    identify.said = phase;
    identify.step = step;
    app.drive.signals.current_frame = (dq_t){0, -current};
    return said();
}

static void expect_runaway(identify_phase_t phase, uint32_t step, int32_t most)
{
    setUp();
    TEST_ASSERT_NULL(strstr(line_with_current(phase, step, most), "refused"));
    setUp();
    assert_starts("identify refused: more current flows than was asked for: does a load turn",
                  line_with_current(phase, step, most + 1));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
}

static void test_a_current_of_a_rotor_that_was_lost_is_no_load(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    (void)next_line();
    identify.phase = IDENTIFY_CATCH;
    identify.said = IDENTIFY_CATCH;
    identify.turn.slower = 1U;
    app.drive.signals.current_frame = (dq_t){-cfg.protection.current_max, 0};
    TEST_ASSERT_EQUAL_STRING("", said());
    app.drive.signals.current_frame = (dq_t){-cfg.protection.current_max - 1, 0};
    assert_starts("identify refused: the rotor falls out of step", said());
}

static void test_a_current_that_runs_away_with_all_of_the_voltage_lacks_the_bus(void)
{
    const int32_t limit = modulator_limit(&cfg.modulator, app.drive.signals.bus);

    TEST_ASSERT_NULL(identify_start(&identify));
    (void)said();
    (void)next_line();
    identify.phase = IDENTIFY_SPIN;
    identify.said = IDENTIFY_SPIN;
    identify.step = 1U;
    app.drive.signals.voltage = (dq_t){-limit, 0};
    app.drive.signals.current_frame = (dq_t){cfg.protection.current_max, 0};
    assert_starts("identify refused: the bus voltage is too low", said());
}

static void test_a_current_that_nobody_asked_for_opens_the_gates(void)
{
    setUp();
    {
        const int32_t continuous = cfg.derating.current_continuous;
        const int32_t fault = cfg.protection.current_max;
        const int32_t middle = (identify_rest_largest(&identify) + fault) / 2;

        expect_runaway(IDENTIFY_PULSE, 1U, (continuous * 5) / 4);
        expect_runaway(IDENTIFY_CATCH, 1U, middle);
        expect_runaway(IDENTIFY_STILL, 1U, middle);
        expect_runaway(IDENTIFY_SPIN, 1U, middle);
        expect_runaway(IDENTIFY_SPIN, 2U, fault);
        expect_runaway(IDENTIFY_RAMP, 1U, fault);
    }
}

/* ---- PULSE ---- */

/* The current of the pulses in the frames of the three axes, as peaks of 64 changes. */
static void answer(uint32_t axis, int32_t d, int32_t q)
{
    TEST_ASSERT_EQUAL_UINT32(axis, identify.rest.axis);
    sums()->change = (dq_t){64 * d, 64 * q};
}

static bool pulse(int32_t a, int32_t b, int32_t c)
{
    bool aims;

    answer(0U, a, 0);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    answer(1U, b, 0);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    answer(2U, c, 0);
    aims = identify_rest_plan_pulse(&identify);
    return aims;
}

static void begin_pulses(void)
{
    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_PULSE;
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
}

static void test_pulses_grow_twofold_and_then_by_a_quarter(void)
{
    int32_t first;

    begin_pulses();
    first = identify.rest.pulse;
    TEST_ASSERT_EQUAL_INT32(app.drive.signals.bus / 256, first);
    TEST_ASSERT_TRUE(pulse(0, 0, 0));
    TEST_ASSERT_EQUAL_INT32(2 * first, identify.rest.pulse);
    TEST_ASSERT_TRUE(pulse(99, 99, 99));
    TEST_ASSERT_EQUAL_INT32(4 * first, identify.rest.pulse);
    TEST_ASSERT_TRUE(pulse(100, 90, 90)); /* a sixteenth */
    TEST_ASSERT_EQUAL_INT32(5 * first, identify.rest.pulse);
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_TRUE(pulse(399, 300, 300));
    TEST_ASSERT_FALSE(pulse(400, 300, 300));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
}

static void test_the_pulses_inductance_leaves_out_what_the_legs_lose(void)
{
    begin_pulses();
    identify.rest.pulse = 1000;
    TEST_ASSERT_TRUE(pulse(200, 200, 200));
    TEST_ASSERT_EQUAL_INT32(1250, identify.rest.pulse);
    TEST_ASSERT_FALSE(pulse(500, 200, 200));
    /* 250 more volts, 300 more current */
    TEST_ASSERT_EQUAL_INT32((250 * 65536) / 300, identify.rest.inductance_q16);
    TEST_ASSERT_EQUAL_INT32(identify.rest.inductance_q16, identify.rest.along_q16);
    TEST_ASSERT_EQUAL_INT32(identify.rest.inductance_q16, identify.rest.across_q16);
}

static void test_pulses_become_longer_when_a_quarter_of_the_bus_is_not_enough(void)
{
    begin_pulses();
    identify.rest.pulse = 5000;
    TEST_ASSERT_TRUE(pulse(10, 10, 10));
    TEST_ASSERT_EQUAL_INT32(2, identify.rest.quarter);
    TEST_ASSERT_EQUAL_INT32(3125, identify.rest.pulse);
    identify.rest.pulse = 5000;
    TEST_ASSERT_TRUE(pulse(200, 50, 50)); /* fine, but a quarter more is too much */
    TEST_ASSERT_FALSE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(4, identify.rest.quarter);
}

static void test_no_current_is_refused(void)
{
    bool aims = true;

    begin_pulses();
    for (uint32_t k = 0U; (k < 40U) && aims; k++) {
        aims = pulse(0, 0, 0);
    }
    assert_refused("is the motor connected?");
}

static void expect_wrong_phase(const dq_t peaks[3], const char *why)
{
    setUp();
    begin_pulses();
    identify.rest.fine = true;
    for (uint32_t axis = 0U; axis < 3U; axis++) {
        answer(axis, peaks[axis].d, peaks[axis].q);
        (void)identify_rest_plan_pulse(&identify);
    }
    if (why == NULL) {
        TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    } else {
        assert_refused(why);
    }
}

static void test_an_open_phase_is_named(void)
{
    expect_wrong_phase((const dq_t[]){{0, 0}, {600, 300}, {600, -300}}, "phase a is open");
    expect_wrong_phase((const dq_t[]){{600, -300}, {-74, 74}, {600, 300}}, "phase b is open");
    expect_wrong_phase((const dq_t[]){{600, 300}, {600, -300}, {0, 0}}, "phase c is open");
    expect_wrong_phase((const dq_t[]){{600, 300}, {600, -300}, {0, -80}}, NULL);
    expect_wrong_phase((const dq_t[]){{600, 0}, {75, 0}, {600, 0}}, NULL);
}

static void test_exchanged_phases_are_named(void)
{
    expect_wrong_phase((const dq_t[]){{-300, 520}, {-300, -520}, {600, 0}}, "of phases a and b");
    expect_wrong_phase((const dq_t[]){{-300, 520}, {600, 0}, {-300, -520}}, "of phases a and c");
    expect_wrong_phase((const dq_t[]){{600, 0}, {-300, 520}, {-300, -520}}, "of phases b and c");
}

/* ---- CATCH ---- */

static void test_a_small_current_rises_opposite_and_takes_the_rotor_along(void)
{
    static const struct {
        int32_t eighths;
        int32_t angle;
    } moves[] = {{1, INT32_MIN}, {2, INT32_MIN}, {2, 0x40000000}, {2, 0}, {3, 0}, {4, 0}};

    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_CATCH;
    identify.rest.inductance_q16 = 65536;
    for (uint32_t k = 0U; k < 6U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
        TEST_ASSERT_EQUAL_INT32(200 * moves[k].eighths,
                                *identify_aim_word(&identify, PROBE_CURRENT));
        TEST_ASSERT_EQUAL_INT32(moves[k].angle, *identify_aim_word(&identify, PROBE_ANGLE));
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MAX / 4000, *identify_aim_word(&identify, PROBE_RATE));
    for (uint32_t k = 6U; k < 10U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    }
    TEST_ASSERT_EQUAL_INT32(0, *identify_aim_word(&identify, PROBE_ANGLE));
    TEST_ASSERT_EQUAL_INT32(1600, *identify_aim_word(&identify, PROBE_CURRENT));
}

static void look(int32_t across)
{
    sums()->across = across;
}

static void test_a_rotor_that_swings_is_waited_for_four_seconds(void)
{
    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_CATCH;
    look(100);
    for (uint32_t k = 0U; k < 51U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    }
    TEST_ASSERT_FALSE(identify_rest_plan_catch(&identify));
    assert_refused("does a load turn it?");
}

static void test_a_rotor_at_rest_goes_on(void)
{
    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_CATCH;
    look(0);
    for (uint32_t k = 0U; k < 11U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    }
    look(100);
    TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    look(99);
    TEST_ASSERT_FALSE(identify_rest_plan_catch(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
}

static void test_noise_is_no_swing(void)
{
    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_CATCH;
    look(0);
    for (uint32_t k = 0U; k < 11U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    }
    sums()->noise_b =
        20 * identify.aim.ticks; /* its largest sample is five times its mean change */
    look(200);
    TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
    look(199);
    TEST_ASSERT_FALSE(identify_rest_plan_catch(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
}

static void test_a_rotor_that_was_lost_goes_on_turning(void)
{
    cfg.derating.current_continuous = 1600;
    identify.aim.ticks = 1;
    identify.phase = IDENTIFY_CATCH;
    identify.turn.slower = 1U;
    identify.step = 11U;
    identify.aim.words[0] = 1600;
    look(0);
    TEST_ASSERT_FALSE(identify_rest_plan_catch(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* ---- STILL ---- */

/* All levels and bursts of an axis, with a winding of R = ohms (Q13) and a loss of 100. */
static void measure_axis(int32_t resistance_q13)
{
    for (uint32_t k = 0U; k < 30U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        {
            const int32_t current = *identify_aim_word(&identify, PROBE_CURRENT);

            sums()->current.d = current * identify.aim.ticks;
            sums()->voltage.d = (((current * resistance_q13) / 8192) + 100) * identify.aim.ticks;
            sums()->change = (dq_t){1000, 2000};
        }
    }
}

static void begin_still(void)
{
    cfg.derating.current_continuous = 1600;
    cfg.derating.current_max = 4000;
    identify.phase = IDENTIFY_STILL;
    identify.rest.along_q16 = 65536;
    identify.rest.across_q16 = 65536;
    identify.aim.ticks = 1;
}

static void test_levels_reach_twice_the_continuous_current_or_nine_tenths_of_the_largest(void)
{
    begin_still();
    TEST_ASSERT_EQUAL_INT32(3200, identify_rest_largest(&identify));
    cfg.derating.current_max = 2000;
    TEST_ASSERT_EQUAL_INT32(1800, identify_rest_largest(&identify));
}

static void test_three_axes_give_r_and_the_loss(void)
{
    begin_still();
    for (uint32_t axis = 0U; axis < 3U; axis++) {
        TEST_ASSERT_EQUAL_UINT32(axis, identify.rest.axis);
        measure_axis(4000);
        TEST_ASSERT_EQUAL(axis < 2U, identify_rest_plan_still(&identify));
        TEST_ASSERT_INT32_WITHIN(8, 4000,
                                 identify.rest.resistance_q13[axis]); /* 1 LSB of 1563 currents */
        TEST_ASSERT_INT32_WITHIN(4, 100, identify.rest.loss);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

static void test_on_the_next_axis_the_levels_wait_until_the_rotor_rests(void)
{
    begin_still();
    measure_axis(4000);
    look(100); /* of 1600 */
    for (uint32_t k = 0U; k < 41U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        TEST_ASSERT_EQUAL_UINT32(1U, identify.rest.axis);
        TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
    }
    look(99);
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_UINT32(1U, identify.step);
    TEST_ASSERT_EQUAL_STRING("still", identify.aim.kind);
}

static void test_a_rotor_that_does_not_rest_on_the_next_axis_is_refused(void)
{
    begin_still();
    measure_axis(4000);
    look(100);
    for (uint32_t k = 0U; k < 41U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    }
    TEST_ASSERT_FALSE(identify_rest_plan_still(&identify));
    assert_refused("does a load turn it?");
}

static void test_a_current_that_the_bus_does_not_drive_is_refused(void)
{
    begin_still();
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    sums()->current.d = ((3200 * 7) / 8) * identify.aim.ticks;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    setUp();
    begin_still();
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    sums()->current.d = 2700 * identify.aim.ticks;
    TEST_ASSERT_FALSE(identify_rest_plan_still(&identify));
    assert_refused("the bus voltage is too low for the current");
}

/* Of three phases: along an axis two thirds of its own R and a sixth of each other one. */
static void measure_windings(int32_t a, int32_t b, int32_t c)
{
    const int32_t phases[] = {a, b, c};

    setUp();
    begin_still();
    for (uint32_t axis = 0U; axis < 3U; axis++) {
        measure_axis((phases[axis] / 2) + ((a + b + c) / 6));
        (void)identify_rest_plan_still(&identify);
    }
}

static void expect_unlike(const char *why, const char *phase)
{
    assert_refused(why);
    TEST_ASSERT_EQUAL_STRING(phase, identify.detail);
}

static void test_windings_that_differ_by_less_than_a_quarter_go_on(void)
{
    measure_windings(4000, 4900, 3100);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

static void test_a_winding_with_less_resistance_is_named_as_shorted(void)
{
    measure_windings(2900, 4000, 4100);
    expect_unlike("is the winding shorted", "a");
    measure_windings(4000, 2900, 4100);
    expect_unlike("is the winding shorted", "b");
    measure_windings(4000, 4100, 2900);
    expect_unlike("is the winding shorted", "c");
}

static void test_a_phase_with_more_resistance_is_named_as_a_bad_contact(void)
{
    measure_windings(5200, 4000, 3900);
    expect_unlike("is a contact bad", "a");
    measure_windings(4000, 5200, 3900);
    expect_unlike("is a contact bad", "b");
    measure_windings(4000, 3900, 5200);
    expect_unlike("is a contact bad", "c");
}

static void test_pulses_on_a_current_take_the_inductance_of_those_before(void)
{
    begin_still();
    identify.rest.along_q16 = 10 * 65536; /* 300 of current in 10 volts a tick each */
    identify.step = 14U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(800, *identify_aim_word(&identify, PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(3000, *identify_aim_word(&identify, PROBE_PULSE_D));
    TEST_ASSERT_EQUAL_INT32(1, *identify_aim_word(&identify, PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
    sums()->change = (dq_t){256 * 600, 0}; /* twice as much as was planned */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(5 * 65536, identify.rest.along_q16);
}

static void test_pulses_without_an_answer_keep_the_inductance(void)
{
    begin_still();
    identify.step = 15U;
    *identify_aim_word(&identify, PROBE_PULSE_D) = 100;
    identify.aim.ticks = 256;
    sums()->change = (dq_t){0, 0};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.along_q16);
    *identify_aim_word(&identify, PROBE_PULSE_D) = 0;
    *identify_aim_word(&identify, PROBE_PULSE_Q) = 100;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
}

static void test_long_pulses_share_their_volts(void)
{
    begin_still();
    identify.rest.across_q16 = 65536 * 40;
    identify.step = 14U + 6U; /* 1600 across */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    {
        const int32_t most = (app.drive.signals.bus * 3) / 8;
        const int32_t quarter = 1 + ((1600 * 40) / most);

        TEST_ASSERT_EQUAL_INT32(quarter, *identify_aim_word(&identify, PROBE_PULSE_TICKS));
        TEST_ASSERT_EQUAL_INT32((1600 * 40) / quarter,
                                *identify_aim_word(&identify, PROBE_PULSE_Q));
        TEST_ASSERT_EQUAL_INT32((256 / (4 * quarter)) * 4 * quarter, identify.aim.ticks);
    }
}

static void test_pulses_are_at_most_64_ticks_and_three_eighths_of_the_bus(void)
{
    begin_still();
    identify.rest.across_q16 = INT32_MAX;
    identify.step = 14U + 6U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(64, *identify_aim_word(&identify, PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32((app.drive.signals.bus * 3) / 8,
                            *identify_aim_word(&identify, PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
}

/* ---- SPIN, RAMP, COAST ---- */

static void begin_spin(void)
{
    cfg.derating.current_continuous = 1600;
    identify.phase = IDENTIFY_SPIN;
    identify.rest.inductance_q16 = 65536;
    identify.rest.resistance_q13[2] = 1000;
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
}

/* A steady window at this speed with an EMF of flux, U_b/Ω_b in Q14. */
static void turn(step_t speed, int32_t flux, int32_t along)
{
    const int64_t ticks = identify.aim.ticks;

    sums()->turn_q16 = (int32_t)(((int64_t)speed * ticks) / 65536);
    sums()->voltage.q = (int32_t)(((((int64_t)speed * ticks) >> 11) * flux) / 16384);
    sums()->voltage.d = (int32_t)(along * ticks);
    sums()->current = (dq_t){(int32_t)(1200 * ticks), 0};
    sums()->torque = 0;
}

static void test_the_highest_speed_is_half_of_the_name_plate(void)
{
    begin_spin();
    TEST_ASSERT_EQUAL_INT32(cfg.speed_loop.speed_max / 2, identify_turn_speed(&identify));
    TEST_ASSERT_EQUAL_INT32(1200, identify_turn_current(&identify));
    TEST_ASSERT_EQUAL_INT32(identify.turn.top / 4, *identify_aim_word(&identify, PROBE_SPEED));
    turn(identify.turn.top / 4, 6000, 300);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(cfg.speed_loop.speed_max / 2, identify.turn.top);
    TEST_ASSERT_EQUAL_INT32(identify.turn.top / 2, *identify_aim_word(&identify, PROBE_SPEED));
}

static void test_a_bus_that_is_short_lowers_the_speed(void)
{
    begin_spin();
    turn(identify.turn.top / 4, 60000, 300);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_TRUE(identify.turn.top < (cfg.speed_loop.speed_max / 2));
}

static void test_a_bus_that_is_far_too_low_is_refused(void)
{
    begin_spin();
    turn(identify.turn.top / 4, 6000, 30000);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_refused("bus voltage is too low");
}

static void use_all_voltage(void)
{
    const int32_t limit = modulator_limit(&cfg.modulator, app.drive.signals.bus);

    app.drive.signals.voltage = (dq_t){0, limit};
}

static void test_a_bus_that_does_not_bring_the_first_speed_is_refused(void)
{
    begin_spin();
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify));
    use_all_voltage();
    TEST_ASSERT_TRUE(identify_turn_lacks_voltage(&identify));
    turn(identify.turn.top / 4, 10, 300); /* the rotor is lost by then */
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_refused("bus voltage is too low");
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify));
}

/* ωL·i of twice the L that the pulses have shown, in the EMF's Q14 of U_b/Ω_b: 2π·1200·2/32768 per volt-tick. */
static void test_a_standing_rotor_with_much_saliency_is_refused(void)
{
    int32_t inductive;

    begin_spin();
    inductive = (((*identify_aim_word(&identify, PROBE_REACTANCE) * 2) / 8) *
                 (identify.aim.words[0] / 64)) /
                64;
    turn(identify.turn.top / 4, 20 + (2 * inductive), 300);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_refused("does not turn with the current");
}

static void test_a_rotor_without_an_emf_is_refused(void)
{
    begin_spin();
    turn(identify.turn.top / 4, 10, 300);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_refused("does not turn with the current");
}

static void spin_to(uint32_t step)
{
    begin_spin();
    for (uint32_t k = 1U; k < step; k++) {
        turn(identify.turn.top / 4, 6000, 300);
        TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    }
}

static void test_the_third_way_is_a_ramp_in_its_window(void)
{
    spin_to(3U);
    TEST_ASSERT_TRUE(identify.aim.leads);
    TEST_ASSERT_EQUAL_STRING("ramp", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(identify.turn.top, *identify_aim_word(&identify, PROBE_SPEED));
    setUp();
    spin_to(4U);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

static void test_half_of_the_current_comes_last(void)
{
    spin_to(5U);
    TEST_ASSERT_EQUAL_INT32(600, *identify_aim_word(&identify, PROBE_CURRENT));
    turn(identify.turn.top, 6000, 300);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    TEST_ASSERT_EQUAL_INT32(1200, *identify_aim_word(&identify, PROBE_CURRENT));
}

static void test_an_emf_that_half_of_the_current_halves_is_none(void)
{
    spin_to(5U);
    turn(identify.turn.top, 3600, 0); /* 6000 with all of it */
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_refused("does not turn with the current");
    setUp();
    spin_to(5U);
    turn(identify.turn.top, 3800, 0);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

static void test_a_rotor_that_lags_at_half_of_the_current_has_its_emf_along_it(void)
{
    spin_to(5U);
    turn(identify.turn.top, 2000, 10000);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

static void test_a_rotor_that_is_lost_is_caught_twice_and_then_refused(void)
{
    for (uint32_t k = 0U; k < 3U; k++) {
        const uint32_t slower = k;

        setUp();
        spin_to(4U);
        identify.turn.slower = slower;
        turn(identify.turn.top, 2000, 300);
        TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
        if (k < 2U) {
            TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
            TEST_ASSERT_EQUAL_UINT32(slower + 1U, identify.turn.slower);
        } else {
            assert_refused("falls out of step");
        }
    }
}

static void test_a_second_attempt_has_half_of_the_slope(void)
{
    step_t first;

    begin_spin();
    first = *identify_aim_word(&identify, PROBE_RAMP);
    identify.step = 0U;
    identify.turn.slower = 1U;
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_INT32_WITHIN(1, first / 2, *identify_aim_word(&identify, PROBE_RAMP));
}

static void begin_ramps(void)
{
    spin_to(5U);
    turn(identify.turn.top, 6000, 300);
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
}

/* A pair of ramps whose torque is this share of what the current can pull, Q14, over the ramp. */
static bool ramp_pair(int32_t share)
{
    bool aims = true;

    for (uint32_t part = 1U; part <= 4U; part++) {
        turn(identify.turn.top, 6000, 300);
        if ((part % 2U) == 1U) {
            const int64_t whole = ((int64_t)1200 * 6000) / 16384;
            const int64_t torque = (whole * share * identify.turn.ramp_ticks) / 16384;

            sums()->torque = (int32_t)((part == 1U) ? -torque : torque);
        }
        aims = identify_turn_plan_ramp(&identify);
    }
    return aims;
}

static void test_ramps_become_steeper_until_the_rotor_lags(void)
{
    int32_t before;

    begin_ramps();
    before = identify.turn.ramp_ticks;
    TEST_ASSERT_TRUE(ramp_pair(1638)); /* a third of what is enough */
    TEST_ASSERT_INT32_WITHIN(before / 50, before / 3, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(0, identify.turn.pairs_left);
    TEST_ASSERT_TRUE(ramp_pair(4915));
    TEST_ASSERT_TRUE(identify.turn.pairs_left >= 2);
}

static void test_a_gentle_ramp_damps_with_the_swing_it_shows(void)
{
    begin_ramps();
    TEST_ASSERT_TRUE(ramp_pair(100)); /* counts as a quarter of enough */
    TEST_ASSERT_TRUE(identify.turn.swing_ticks >= 8);
    TEST_ASSERT_EQUAL_INT32(fx_min((2 * 683565276) / identify.turn.swing_ticks, 41000000),
                            *identify_aim_word(&identify, PROBE_DAMPING));
}

static void test_a_long_ramp_goes_less_far_down(void)
{
    begin_ramps();
    identify.turn.ramp_ticks = 5000;
    identify.turn.low = identify.turn.top / 2;
    TEST_ASSERT_TRUE(ramp_pair(3000));
    TEST_ASSERT_TRUE(identify.turn.ramp_ticks <= 6000);
    TEST_ASSERT_TRUE(identify.turn.low >= (identify.turn.top / 2));
}

static void test_a_ramp_is_not_so_short_that_a_current_across_flows(void)
{
    begin_ramps();
    for (uint32_t k = 0U; (k < 12U) && (identify.turn.pairs_left == 0); k++) {
        TEST_ASSERT_TRUE(ramp_pair(200));
    }
    TEST_ASSERT_TRUE(identify.turn.pairs_left > 0); /* it is short enough */
    TEST_ASSERT_TRUE(identify.turn.ramp_ticks >= 64);
}

static void test_after_the_last_pair_it_coasts(void)
{
    bool aims = true;

    begin_ramps();
    for (uint32_t k = 0U; (k < 20U) && aims; k++) {
        aims = ramp_pair(4915);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_COAST, identify.phase);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

static void test_a_rotor_lost_in_a_ramp_is_caught(void)
{
    begin_ramps();
    turn(identify.turn.top, 6000, 300);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    turn(identify.turn.top, 1000, 300);
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
}

static void begin_coast(void)
{
    begin_ramps();
    identify_aim_phase(&identify, IDENTIFY_COAST);
    turn(identify.turn.top, 6000, 0);
    TEST_ASSERT_TRUE(identify_turn_plan_coast(&identify));
}

static bool coast_at(step_t speed)
{
    turn(speed, 6000, 0);
    return identify_turn_plan_coast(&identify);
}

static void test_coasting_has_no_current_and_follows_the_rotor(void)
{
    begin_coast();
    TEST_ASSERT_EQUAL_INT32(0, *identify_aim_word(&identify, PROBE_CURRENT));
    TEST_ASSERT_TRUE(*identify_aim_word(&identify, PROBE_TRACKING) > 0);
    TEST_ASSERT_TRUE(identify.aim.rushes);
    TEST_ASSERT_TRUE(identify.aim.settle > 0);
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_EQUAL_INT32(0, identify.aim.settle);
}

static void test_windows_of_coasting_grow_while_the_speed_holds(void)
{
    int32_t first;

    begin_coast();
    first = identify.aim.ticks;
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_TRUE(identify.aim.ticks > first);
    for (uint32_t k = 0U; k < 10U; k++) {
        TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    }
    TEST_ASSERT_TRUE(identify.aim.ticks <= 1600);
    first = identify.aim.ticks;
    TEST_ASSERT_TRUE(coast_at((identify.turn.top / 4) * 3));
    TEST_ASSERT_EQUAL_INT32(first, identify.aim.ticks);
}

static void test_coasting_ends_at_half_of_the_speed(void)
{
    begin_coast();
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_TRUE(coast_at(identify.turn.top));
    TEST_ASSERT_TRUE(coast_at((identify.turn.top / 5) * 3));
    TEST_ASSERT_FALSE(coast_at((identify.turn.top / 5) * 2));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
}

static void test_coasting_ends_after_its_windows(void)
{
    uint32_t windows = 1U;

    begin_coast();
    while ((windows < 100U) && coast_at(identify.turn.top)) {
        windows++;
    }
    TEST_ASSERT_EQUAL_UINT32(19U, windows);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_starts_from_ready_only);
    RUN_TEST(test_a_current_that_the_converter_hardly_sees_is_refused_with_the_one_it_takes);
    RUN_TEST(test_it_says_its_scales_and_what_it_will_do);
    RUN_TEST(test_a_record_has_20_numbers);
    RUN_TEST(test_stop_opens_the_gates);
    RUN_TEST(test_a_stop_of_what_is_not_busy_stops_nothing);
    RUN_TEST(test_a_fault_ends_it_with_a_line);
    RUN_TEST(test_every_phase_is_said_before_it_begins);
    RUN_TEST(test_a_current_of_a_rotor_that_was_lost_is_no_load);
    RUN_TEST(test_a_current_that_runs_away_with_all_of_the_voltage_lacks_the_bus);
    RUN_TEST(test_a_current_that_nobody_asked_for_opens_the_gates);
    RUN_TEST(test_noise_beyond_a_sixteenth_of_the_current_is_refused);
    RUN_TEST(test_pulses_grow_twofold_and_then_by_a_quarter);
    RUN_TEST(test_the_pulses_inductance_leaves_out_what_the_legs_lose);
    RUN_TEST(test_pulses_become_longer_when_a_quarter_of_the_bus_is_not_enough);
    RUN_TEST(test_no_current_is_refused);
    RUN_TEST(test_an_open_phase_is_named);
    RUN_TEST(test_exchanged_phases_are_named);
    RUN_TEST(test_a_small_current_rises_opposite_and_takes_the_rotor_along);
    RUN_TEST(test_a_rotor_that_swings_is_waited_for_four_seconds);
    RUN_TEST(test_a_rotor_at_rest_goes_on);
    RUN_TEST(test_noise_is_no_swing);
    RUN_TEST(test_a_rotor_that_was_lost_goes_on_turning);
    RUN_TEST(test_levels_reach_twice_the_continuous_current_or_nine_tenths_of_the_largest);
    RUN_TEST(test_three_axes_give_r_and_the_loss);
    RUN_TEST(test_on_the_next_axis_the_levels_wait_until_the_rotor_rests);
    RUN_TEST(test_a_rotor_that_does_not_rest_on_the_next_axis_is_refused);
    RUN_TEST(test_a_current_that_the_bus_does_not_drive_is_refused);
    RUN_TEST(test_windings_that_differ_by_less_than_a_quarter_go_on);
    RUN_TEST(test_a_winding_with_less_resistance_is_named_as_shorted);
    RUN_TEST(test_a_phase_with_more_resistance_is_named_as_a_bad_contact);
    RUN_TEST(test_pulses_on_a_current_take_the_inductance_of_those_before);
    RUN_TEST(test_pulses_without_an_answer_keep_the_inductance);
    RUN_TEST(test_long_pulses_share_their_volts);
    RUN_TEST(test_pulses_are_at_most_64_ticks_and_three_eighths_of_the_bus);
    RUN_TEST(test_the_highest_speed_is_half_of_the_name_plate);
    RUN_TEST(test_a_bus_that_is_short_lowers_the_speed);
    RUN_TEST(test_a_bus_that_is_far_too_low_is_refused);
    RUN_TEST(test_a_bus_that_does_not_bring_the_first_speed_is_refused);
    RUN_TEST(test_a_standing_rotor_with_much_saliency_is_refused);
    RUN_TEST(test_a_rotor_without_an_emf_is_refused);
    RUN_TEST(test_an_emf_that_half_of_the_current_halves_is_none);
    RUN_TEST(test_a_rotor_that_lags_at_half_of_the_current_has_its_emf_along_it);
    RUN_TEST(test_the_third_way_is_a_ramp_in_its_window);
    RUN_TEST(test_half_of_the_current_comes_last);
    RUN_TEST(test_a_rotor_that_is_lost_is_caught_twice_and_then_refused);
    RUN_TEST(test_a_second_attempt_has_half_of_the_slope);
    RUN_TEST(test_ramps_become_steeper_until_the_rotor_lags);
    RUN_TEST(test_a_gentle_ramp_damps_with_the_swing_it_shows);
    RUN_TEST(test_a_long_ramp_goes_less_far_down);
    RUN_TEST(test_a_ramp_is_not_so_short_that_a_current_across_flows);
    RUN_TEST(test_after_the_last_pair_it_coasts);
    RUN_TEST(test_a_rotor_lost_in_a_ramp_is_caught);
    RUN_TEST(test_coasting_has_no_current_and_follows_the_rotor);
    RUN_TEST(test_windows_of_coasting_grow_while_the_speed_holds);
    RUN_TEST(test_coasting_ends_at_half_of_the_speed);
    RUN_TEST(test_coasting_ends_after_its_windows);
    return UNITY_END();
}
