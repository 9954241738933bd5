/* SPDX-License-Identifier: MIT */
/* Plans of a rotor that turns: what follows from the sums of the window that has ended. */
#include "identify_turn.h"

#include "example_identify.h"
#include "testing.h"

#define TOP (14316557)    /* half of 2000 rpm */
#define QUARTER (3579139) /* of that */
#define CURRENT (4128)    /* 3/4 of the continuous one */
#define INDUCTANCE (1441)
#define RESISTANCE (1547)
#define REACTANCE (17) /* 1441/2^16 volt-ticks at 2^26 steps a tick, 2π/64: 17.7 in Q13 */
#define DAMPING_MOST (41000000)

void setUp(void)
{
    identify_example();
}

/* The means of the window that has ended, at so many steps a tick. */
static void answer_spin(int32_t along, int32_t across, step_t speed)
{
    const int32_t ticks = identify.aim.ticks;

    *sums() = (probe_sums_t){.voltage = {along * ticks, across * ticks}};
    sums()->current.d = word(PROBE_CURRENT) * ticks;
    sums()->turn_q16 = (int32_t)(((int64_t)speed * ticks) / 65536);
}

/* ---- SPIN ---- */

static void begin_spinning(void)
{
    setUp();
    begin_phase(IDENTIFY_SPIN);
    identify.rest.inductance_q16 = INDUCTANCE;
    identify.rest.resistance_q13[0] = 1;
    identify.rest.resistance_q13[1] = 2;
    identify.rest.resistance_q13[2] = RESISTANCE;
    identify.rest.loss = 100;
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
}

static void begin_spin(int32_t along, int32_t across)
{
    begin_spinning();
    answer_spin(along, across, QUARTER);
    (void)identify_turn_plan_spin(&identify);
}

TEST(test_the_current_is_three_quarters_and_the_speed_half_of_the_name_plate)
{
    TEST_ASSERT_EQUAL_INT32(CURRENT, identify_turn_current(&identify));
    TEST_ASSERT_EQUAL_INT32(TOP, identify_turn_speed(&identify));
}

TEST(test_the_words_of_a_turning_vector_are_those_of_the_winding)
{
    begin_spinning();
    TEST_ASSERT_EQUAL_INT32(CURRENT, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(RESISTANCE, word(PROBE_RESISTANCE));
    TEST_ASSERT_EQUAL_INT32(REACTANCE, word(PROBE_REACTANCE));
    TEST_ASSERT_EQUAL_INT32(100, word(PROBE_LOSS));
    TEST_ASSERT_EQUAL_INT32(((RESISTANCE * CURRENT) / 8192) / 2, word(PROBE_EMF));
    TEST_ASSERT_EQUAL_INT32(DAMPING_MOST, word(PROBE_DAMPING));
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_Q)); /* stiff */
}

/* Twice the loss of the legs where R·i is small. */
TEST(test_an_emf_counts_from_what_the_legs_lose)
{
    setUp();
    begin_phase(IDENTIFY_SPIN);
    identify.rest.loss = 100;
    identify.rest.resistance_q13[2] = 700; /* 352 */
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL_INT32(200, word(PROBE_EMF));
    identify.rest.resistance_q13[2] = 32767; /* 16511 */
    identify.step = 0U;
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL_INT32(8255, word(PROBE_EMF));
}

TEST(test_a_reactance_saturates)
{
    setUp();
    begin_phase(IDENTIFY_SPIN);
    identify.rest.inductance_q16 = 3000000;
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL_INT32(32767, word(PROBE_REACTANCE));
}

/* From rest to the highest speed in 2 s. */
TEST(test_the_vector_reaches_a_quarter_and_half_of_the_speed_on_a_gentle_ramp)
{
    begin_spinning();
    TEST_ASSERT_EQUAL_INT32(TOP / 4, word(PROBE_SPEED));
    TEST_ASSERT_EQUAL_INT32(TOP / (2000 * MS), word(PROBE_RAMP));
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(150 * MS, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(80 * MS, identify.aim.ticks);
    TEST_ASSERT_FALSE(identify.aim.leads);
    answer_spin(500, 2000, QUARTER);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(TOP / 2, word(PROBE_SPEED));
    TEST_ASSERT_EQUAL_INT32(TOP / (2000 * MS), word(PROBE_RAMP));
}

TEST(test_a_ramp_has_a_slope_whatever_the_speed)
{
    cfg.speed_loop.speed_max = 0x20000000;
    begin_phase(IDENTIFY_SPIN);
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL_INT32(0x10000000 / 20000, word(PROBE_RAMP));
    cfg.speed_loop.speed_max = 40000;
    identify.step = 0U;
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL_INT32(1, word(PROBE_RAMP));
}

TEST(test_each_further_attempt_has_half_of_the_slope)
{
    for (uint32_t slower = 0U; slower < 3U; slower++) {
        setUp();
        begin_phase(IDENTIFY_SPIN);
        identify.turn.slower = slower;
        (void)identify_turn_plan_spin(&identify);
        TEST_ASSERT_EQUAL_INT32(TOP / ((2000 * MS) << slower), word(PROBE_RAMP));
    }
}

/* 12/16 of 0.5485 of the bus, 9286: with 3000 across at a quarter of it 9272/3000 of that are there. */
TEST(test_the_highest_speed_is_that_for_which_the_bus_is_there)
{
    begin_spin(500, 3000);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    TEST_ASSERT_INT32_WITHIN(QUARTER / 3000, (int32_t)(QUARTER * (9272.0 / 3000.0)),
                             identify.turn.top);
    begin_spin(-8000, 3000); /* with a lag the voltage along is negative */
    TEST_ASSERT_INT32_WITHIN(QUARTER / 3000, (int32_t)(QUARTER * (4714.9 / 3000.0)),
                             identify.turn.top);
    begin_spin(500, 2000);
    TEST_ASSERT_EQUAL_INT32(TOP, identify.turn.top);
}

#define OUT_OF_STEP "the rotor falls out of step: is the load too large, or does it change?"
#define STANDS "the rotor does not turn with the current: is it blocked, braked, or loaded?"

static void assert_caught(uint32_t times)
{
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    TEST_ASSERT_EQUAL_UINT32(times, identify.turn.slower);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

/* 512/2^16 of a turn are 16384 of Q15: the sum of the voltage is the flux. */
static void answer_flux(int32_t flux_q14)
{
    *sums() = (probe_sums_t){.turn_q16 = 512, .voltage = {0, flux_q14}};
}

static void spin_with(int32_t inductance_q16, int32_t flux_q14)
{
    begin_spinning();
    identify.rest.inductance_q16 = inductance_q16;
    answer_flux(flux_q14);
    (void)identify_turn_plan_spin(&identify);
}

/* Lost so often before, in ramps that were steep. */
static void lose(uint32_t times)
{
    identify.turn.slower = times;
    identify.turn.steep = true;
    identify.aim.leads = true;
}

/* 1/20 of the voltage at the highest speed: 12382/20 at 13981 is a flux of 725, and 4 are L·i; 77.7 at 1747. */
TEST(test_a_rotor_that_does_not_turn_has_no_emf)
{
    begin_spin(500, 60);
    assert_caught(1U);
    begin_spin(500, 77);
    assert_caught(1U);
    begin_spin(500, 78);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    begin_spin(500, -3000); /* it turns the other way */
    assert_caught(1U);
    spin_with(INDUCTANCE, 725 + 3);
    assert_caught(1U);
    spin_with(INDUCTANCE, 725 + 4);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* Of 100 times the inductance L·i is 442: 1768 of Q13 times 4128/2^14. Of 1000 times it is 4420, and 1/4 of that above it counts. */
TEST(test_the_voltage_of_the_inductance_is_no_emf)
{
    spin_with(100 * INDUCTANCE, 442 + 724);
    assert_caught(1U);
    spin_with(100 * INDUCTANCE, 442 + 725);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    spin_with(1000 * INDUCTANCE, 4420 + 1104);
    assert_caught(1U);
    spin_with(1000 * INDUCTANCE, 4420 + 1105);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* A heavy rotor follows a slower way to this speed. */
TEST(test_a_rotor_that_is_left_behind_is_caught_twice_and_then_refused)
{
    for (uint32_t lost = 0U; lost < 3U; lost++) {
        begin_spinning();
        lose(lost);
        answer_spin(500, 60, QUARTER);
        TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
        if (lost < 2U) {
            assert_caught(lost + 1U);
        } else {
            assert_refused(STANDS);
        }
    }
}

/* A highest speed below one of Q15 counts as one: an EMF of 1/20 of the voltage is 619. */
TEST(test_a_highest_speed_of_nothing_divides_by_nothing)
{
    cfg.speed_loop.speed_max = 2000;
    begin_phase(IDENTIFY_SPIN);
    (void)identify_turn_plan_spin(&identify);
    *sums() = (probe_sums_t){.turn_q16 = 1, .voltage = {0, 19811}}; /* over 32 of Q15 */
    (void)identify_turn_plan_spin(&identify);
    assert_caught(1U);
    identify_aim_phase(&identify, IDENTIFY_SPIN);
    (void)identify_turn_plan_spin(&identify);
    *sums() = (probe_sums_t){.turn_q16 = 1, .voltage = {0, 19812}}; /* 619.1 */
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

#define TOO_LOW "the bus voltage is too low to turn the motor at 1/8 of its highest speed"

/* 1/16 is half of a quarter of half: 1500 of 3000 have to be left. */
TEST(test_a_bus_that_is_too_low_is_refused)
{
    begin_spin(9200, 3000);
    assert_refused(TOO_LOW);
    begin_spin(20000, 3000);
    assert_refused(TOO_LOW);
    begin_spin(9180, 3000); /* 1398 */
    assert_refused(TOO_LOW);
    begin_spin(9150, 3000); /* 1584 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    begin_spin(0, 18590); /* half of it are 9295 */
    assert_refused(TOO_LOW);
    begin_spin(0, 18550);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* A rotor that stands does so whatever voltage is left. */
TEST(test_a_standing_rotor_is_named_before_a_bus_that_is_too_low)
{
    begin_spin(20000, 60);
    assert_caught(1U);
}

static void spin_at(dq_t voltage)
{
    begin_spinning();
    app.drive.signals.voltage = voltage;
    answer_spin(500, 2000, QUARTER);
    (void)identify_turn_plan_spin(&identify);
}

/* 12382 is the limit: 1/32 of it is left, 386. */
TEST(test_a_bus_whose_whole_voltage_is_used_is_too_low)
{
    spin_at((dq_t){0, 11996});
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    spin_at((dq_t){0, 11997});
    assert_refused(TOO_LOW);
    spin_at((dq_t){-11997, 0});
    assert_refused(TOO_LOW);
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify)); /* it is said already */
}

/* Later on the speed is bounded by what it has taken. */
TEST(test_the_whole_voltage_counts_at_a_quarter_of_the_speed_only)
{
    begin_spinning();
    app.drive.signals.voltage = (dq_t){0, 12382};
    TEST_ASSERT_TRUE(identify_turn_lacks_voltage(&identify));
    identify.step = 0U;
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify));
    identify.step = 2U;
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify));
    identify_aim_phase(&identify, IDENTIFY_RAMP);
    identify.step = 1U;
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify));
}

/* 2000 at a quarter of the speed. */
static void spin_on(uint32_t step)
{
    static const int32_t across[] = {2000, 4000, 8000, 8000};
    static const step_t speed[] = {QUARTER, TOP / 2, TOP, TOP};

    while (identify.step < step) {
        answer_spin(500, across[identify.step - 1U], speed[identify.step - 1U]);
        TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    }
}

static void spin_to(uint32_t step)
{
    begin_spinning();
    identify.turn.swing_ticks = 77; /* of an attempt before */
    spin_on(step);
}

/* 1 s; its window has a quarter of that before it and behind. */
TEST(test_the_way_from_half_of_the_speed_to_the_whole_is_a_ramp_in_its_window)
{
    spin_to(3U);
    TEST_ASSERT_TRUE(identify.aim.leads);
    TEST_ASSERT_EQUAL_STRING("ramp", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(TOP, word(PROBE_SPEED));
    TEST_ASSERT_EQUAL_INT32((TOP - (TOP / 2)) / (1000 * MS), word(PROBE_RAMP));
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    TEST_ASSERT_EQUAL_INT32(250 * MS, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32((1000 + 250 + 250) * MS, identify.aim.ticks);
    TEST_ASSERT_EQUAL_INT32(0, identify.turn.swing_ticks);
    spin_to(4U);
    TEST_ASSERT_FALSE(identify.aim.leads);
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_TRUE(identify.turn.swing_ticks > 100);
    TEST_ASSERT_EQUAL_INT32((150 * MS) + (8 * identify.turn.swing_ticks), identify.aim.settle);
}

TEST(test_the_first_ramp_of_a_further_attempt_has_half_of_the_slope)
{
    begin_spinning();
    identify.turn.slower = 1U;
    answer_spin(500, 2000, QUARTER);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(2000 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    answer_spin(500, 4000, TOP / 2);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(450 * MS, identify.aim.settle); /* a quarter would be 500 */
    TEST_ASSERT_EQUAL_INT32((2000 + 450 + 450) * MS, identify.aim.ticks);
}

/*
 * A low bus leaves 1791690 of the highest speed, half of which is far below the quarter where that shows: 3.0 s in a first
 * attempt, and twice as much in each further one. A vector that takes 5 s, and twice as much, is lost (identify.c).
 */
TEST(test_no_vector_moves_so_long_as_one_that_is_lost)
{
    for (uint32_t slower = 0U; slower < 3U; slower++) {
        int32_t ticks;

        begin_spinning();
        identify.turn.slower = slower;
        answer_spin(0, 18550, QUARTER);
        TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
        TEST_ASSERT_EQUAL_INT32(1791690 / 2, word(PROBE_SPEED));
        ticks = (QUARTER - (1791690 / 2)) / word(PROBE_RAMP);
        TEST_ASSERT_TRUE(ticks > ((3000 * MS) << slower));
        TEST_ASSERT_TRUE(ticks < ((5000 * MS) << slower));
    }
}

/* At 100 kHz the 4 s of a third attempt have three times the ticks of a window: half of a window is the ramp's. */
TEST(test_a_ramp_too_long_for_its_window_begins_at_a_higher_speed)
{
    begin_spinning();
    identify.ms_ticks = 100;
    identify.turn.slower = 2U;
    answer_spin(500, 2000, QUARTER);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(PROBE_WINDOW_MAX / 2, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP - (((TOP - (TOP / 2)) / 400000) * 65535), identify.turn.low);
    TEST_ASSERT_EQUAL_INT32(identify.turn.low, word(PROBE_SPEED));
    answer_spin(500, 4000, identify.turn.low);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32((TOP - (TOP / 2)) / 400000, word(PROBE_RAMP));
    TEST_ASSERT_EQUAL_INT32(65535 / 4, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(65535 + (2 * (65535 / 4)), identify.aim.ticks);
}

/* The mean of its window is no EMF of one speed. */
TEST(test_in_the_first_ramp_no_rotor_is_lost)
{
    spin_to(3U);
    answer_spin(500, 100, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_UINT32(4U, identify.step);
}

static int32_t flux_of(int32_t turn_q16, int32_t voltage)
{
    identify.phase = IDENTIFY_SPIN;
    identify.step = 2U;
    *sums() = (probe_sums_t){.turn_q16 = turn_q16, .voltage = {0, voltage}};
    (void)identify_turn_plan_spin(&identify);
    return identify.turn.flux_q14;
}

/* 32 of Q15 for 2^-16 of a turn. */
TEST(test_a_flux_is_voltage_over_speed)
{
    begin_spin(500, 2000);
    TEST_ASSERT_EQUAL_INT32(163840, flux_of(1000000, 320000000));
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(1000000, 32000000));
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(1000000, 32001757)); /* 16384.9 */
    TEST_ASSERT_EQUAL_INT32(1, flux_of(1000000, -32000000));
    TEST_ASSERT_EQUAL_INT32(1, flux_of(1000000, 0));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, flux_of(1, 4194304)); /* 2^31 */
    TEST_ASSERT_EQUAL_INT32(INT32_MAX - 511, flux_of(1, 4194303));
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(1, 32));
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(0, 32));
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(-5, 32));
    cfg.speed_shift = 20U;
    TEST_ASSERT_EQUAL_INT32(16384, flux_of(1, 1)); /* 1/16 counts as 1 */
}

/* The EMF of half of the speed, ωL·i with it: 4000 over 3495.3 of Q15. */
TEST(test_the_flux_is_what_half_of_the_speed_shows)
{
    spin_to(3U);
    TEST_ASSERT_INT32_WITHIN(18750 / 1000, (int32_t)((4000.0 / 3495.25) * 16384.0),
                             identify.turn.flux_q14);
}

TEST(test_half_of_the_current_comes_last)
{
    spin_to(5U);
    TEST_ASSERT_EQUAL_INT32(CURRENT / 2, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32((150 * MS) + (8 * identify.turn.swing_ticks), identify.aim.settle);
    answer_spin(500, 8000, TOP);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    TEST_ASSERT_EQUAL_INT32(CURRENT, word(PROBE_CURRENT));
}

/* Of half of the current R·i is 389, and the legs lose 100: what is above it along the current is EMF. */
static void at_half_of_the_current(int32_t emf_d, int32_t emf_q)
{
    spin_to(5U);
    answer_spin(389 + 100 + emf_d, emf_q, TOP);
    (void)identify_turn_plan_spin(&identify);
}

/* 5/8 of 8000 at the whole speed: an EMF does not halve with the current, the L·i of a standing rotor does. */
TEST(test_a_rotor_whose_emf_falls_with_the_current_has_stood)
{
    at_half_of_the_current(0, 4990);
    assert_caught(1U);
    at_half_of_the_current(0, 5010);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

/* A flux of 5000 without a lag, of 8000 with the whole current: one less falls by more than 3/8. */
TEST(test_an_emf_that_falls_by_three_eighths_is_still_one)
{
    for (int32_t less = 0; less < 2; less++) {
        spin_to(5U);
        identify.turn.flux_q14 = 8000;
        answer_flux(5000 - less);
        sums()->voltage.d = (389 + 100) * identify.aim.ticks;
        (void)identify_turn_plan_spin(&identify);
        TEST_ASSERT_EQUAL((less == 0) ? IDENTIFY_RAMP : IDENTIFY_CATCH, identify.phase);
    }
}

/* √(4000² + 3000²) is 5000. */
TEST(test_the_emf_of_a_rotor_that_lags_is_along_the_current_too)
{
    at_half_of_the_current(3980, 3000);
    assert_caught(1U);
    at_half_of_the_current(4015, 3000);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    at_half_of_the_current(-3980, 3000);
    assert_caught(1U);
    at_half_of_the_current(-4015, 3000);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    at_half_of_the_current(4015, 0);
    assert_caught(1U);
    at_half_of_the_current(10000, 200);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

static void expect_stood(dq_t voltage, int32_t whole_q14, bool stood)
{
    spin_to(5U);
    identify.rest.resistance_q13[2] = 32767; /* 8255 of half of the current */
    identify.turn.flux_q14 = whole_q14;
    answer_spin(8255 + 100 + voltage.d, voltage.q, TOP);
    (void)identify_turn_plan_spin(&identify);
    TEST_ASSERT_EQUAL(stood ? IDENTIFY_CATCH : IDENTIFY_RAMP, identify.phase);
}

/* A flux of 2.34 for a volt. Voltages end at 16 bits: |e| of 32829 and 32767. A lag ends at 32; none across counts as 1. */
TEST(test_the_emf_of_a_lag_has_its_bounds)
{
    expect_stood((dq_t){-41122, 2000}, 122000, false); /* 8/5 of 76944 are 123110 */
    expect_stood((dq_t){-41122, 2000}, 124000, true);
    expect_stood((dq_t){0, 40000}, 122000, false); /* 76721 are 122754 */
    expect_stood((dq_t){0, 40000}, 124000, true);
    expect_stood((dq_t){15, 1}, 48, false); /* 15·2 */
    expect_stood((dq_t){15, 1}, 49, true);
    expect_stood((dq_t){100, 1}, 101, false); /* 32767/1024·2 are 63.998 */
    expect_stood((dq_t){100, 1}, 102, true);
}

/* A rotor whose axes have unlike L is found there only. */
TEST(test_a_rotor_that_has_stood_is_caught_twice_and_then_refused)
{
    for (uint32_t lost = 0U; lost < 3U; lost++) {
        spin_to(5U);
        lose(lost);
        answer_spin(389 + 100, 4990, TOP);
        TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
        if (lost < 2U) {
            assert_caught(lost + 1U);
        } else {
            assert_refused(STANDS);
        }
    }
}

/* At the whole current R·i is 779, and the legs lose 100. Of the largest R it is 16511. */
static void lag_of(int32_t resistance_q13, int32_t emf_d, int32_t emf_q)
{
    spin_to(4U);
    identify.rest.resistance_q13[2] = resistance_q13;
    answer_spin(((resistance_q13 == RESISTANCE) ? 779 : 16511) + 100 + emf_d, emf_q, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_UINT32(5U, identify.step);
}

static void lag_with(int32_t emf_d, int32_t emf_q)
{
    lag_of(RESISTANCE, emf_d, emf_q);
}

static void expect_other_current(bool loaded, int32_t current)
{
    TEST_ASSERT_EQUAL(loaded, identify.turn.loaded);
    TEST_ASSERT_EQUAL_INT32(current, word(PROBE_CURRENT));
}

/* |e| over e_q beyond 1093/1024: beside 8192 across that is 8752, from 3081 along on. */
TEST(test_a_rotor_that_lags_by_20_degrees_has_the_continuous_current)
{
    lag_with(3080, 8192);
    expect_other_current(false, CURRENT / 2);
    lag_with(3081, 8192);
    expect_other_current(true, CONTINUOUS);
    lag_with(-3080, 8192);
    expect_other_current(false, CURRENT / 2);
    lag_with(-3081, 8192);
    expect_other_current(true, CONTINUOUS);
    lag_of(32767, 3080, 8192);
    expect_other_current(false, CURRENT / 2);
    lag_of(32767, 3081, 8192);
    expect_other_current(true, CONTINUOUS);
}

/* Its EMF falls with the lag, whatever it is. The ramps keep its current. */
TEST(test_a_loaded_rotor_is_not_asked_whether_it_has_stood)
{
    lag_with(4000, 8192);
    answer_spin(0, 100, TOP);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
    answer_spin(500, 8000, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
}

/* Its slower ramps may leave more of the torque to friction. */
TEST(test_a_further_attempt_asks_for_the_load_anew)
{
    lag_with(4000, 8192);
    expect_other_current(true, CONTINUOUS);
    identify_turn_catch_again(&identify);
    identify_aim_phase(&identify, IDENTIFY_SPIN);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(CURRENT, word(PROBE_CURRENT));
    spin_on(5U);
    expect_other_current(false, CURRENT / 2);
    answer_spin(389 + 100, 4990, TOP);
    TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
    assert_caught(2U);
}

/* Half of the flux of before is the least. */
TEST(test_a_rotor_out_of_step_is_caught_twice_and_then_refused)
{
    for (uint32_t lost = 0U; lost < 3U; lost++) {
        spin_to(4U);
        lose(lost);
        answer_spin(500, 3990, TOP);
        TEST_ASSERT_FALSE(identify_turn_plan_spin(&identify));
        if (lost < 2U) {
            assert_caught(lost + 1U);
        } else {
            assert_refused(OUT_OF_STEP);
        }
    }
    spin_to(4U);
    answer_spin(500, 4010, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
}

/* ---- RAMP ---- */

#define ACROSS (2000) /* at a quarter of the speed */

/* A torque over what the current can pull, as a share of the flux that shows. */
static void answer_ramp(double share)
{
    const double flux = ACROSS / (QUARTER / 2048.0);
    const double current = word(PROBE_CURRENT);

    answer_spin(500, (int32_t)(((double)identify.turn.top / QUARTER) * ACROSS), identify.turn.top);
    sums()->torque = (int32_t)(share * flux * current * identify.turn.ramp_ticks);
}

static void begin_ramps(double share)
{
    begin_spin(500, ACROSS);
    while (identify.phase == IDENTIFY_SPIN) {
        answer_ramp(share);
        (void)identify_turn_plan_spin(&identify);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

/* One pair: down, hold, up, hold. */
static void pair_of_ramps(double down, double up)
{
    for (uint32_t part = 0U; (part < 4U) && (identify.phase == IDENTIFY_RAMP); part++) {
        answer_ramp((part == 1U) ? down : up);
        (void)identify_turn_plan_ramp(&identify);
    }
}

/* 0.3 lets the rotor lag enough: 1 s stays, but 400 ms are the longest ramp, from 4/5 of the speed then. */
TEST(test_a_first_ramp_that_is_steep_enough_keeps_its_slope_and_goes_less_far_down)
{
    begin_ramps(0.3);
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_INT32_WITHIN(TOP / 1000, (TOP / 5) * 4, identify.turn.low);
}

/* 2/5 of the torque, 2/5 of the time; 1/ω_n² = T·0.12/Δω in radians. */
TEST(test_a_first_ramp_of_less_torque_becomes_as_much_steeper)
{
    int32_t swing;

    begin_ramps(0.12);
    TEST_ASSERT_INT32_WITHIN(120, 400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_TRUE(identify.turn.ramp_ticks < (400 * MS));
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    swing = identify.turn.swing_ticks;
    TEST_ASSERT_INT32_WITHIN(1, 338, swing); /* √(10000·0.12·2^32/2π/7158279) */
    TEST_ASSERT_EQUAL_INT32((2 * 683565276) / swing, word(PROBE_DAMPING));
}

/* A quarter of what is enough counts at least: the next ramp is 4 times as steep at most. */
TEST(test_a_ramp_without_torque_becomes_four_times_as_steep)
{
    begin_ramps(0.001);
    TEST_ASSERT_INT32_WITHIN(50, (1000 * MS) / 4, identify.turn.ramp_ticks);
    TEST_ASSERT_INT32_WITHIN(1, 267, identify.turn.swing_ticks);
    begin_ramps(-0.3);
    TEST_ASSERT_INT32_WITHIN(50, (1000 * MS) / 4, identify.turn.ramp_ticks);
}

/* The first ramp ends with no torque: 1228 of 2^14 count. */
static void steepen_from(int32_t ramp, step_t low)
{
    spin_to(3U);
    identify.turn.ramp_ticks = ramp;
    identify.turn.low = low;
    answer_spin(500, 8000, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
}

/* 1228 of 2^14 are 76 of the 307 that are enough: 16158 becomes 4000. A longer one ends its slope above half of the speed. */
TEST(test_a_ramp_of_more_than_400_ms_goes_less_far_down)
{
    steepen_from(16158, TOP / 2);
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    steepen_from(16162, TOP / 2); /* 4001 */
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP - (((TOP - (TOP / 2)) / 4001) * 4000), identify.turn.low);
}

/* 400 ms of 200 ticks would not fit their window. */
TEST(test_a_ramp_has_half_of_a_window_at_most)
{
    spin_to(3U);
    identify.ms_ticks = 200;
    identify.turn.ramp_ticks = 300000;
    answer_spin(500, 8000, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32(PROBE_WINDOW_MAX / 2, identify.turn.ramp_ticks);
}

TEST(test_the_swing_of_any_ramp_has_its_bounds)
{
    steepen_from(12000, TOP / 2);
    TEST_ASSERT_EQUAL_INT32(292, identify.turn.swing_ticks); /* √(899·2^32/2π/7158279): 292.99 */
    steepen_from(64, TOP);                                   /* of no change: √(4·2^32/2π) */
    TEST_ASSERT_EQUAL_INT32(52290, identify.turn.swing_ticks);
    steepen_from(12000, TOP); /* its square beyond 32 bits */
    TEST_ASSERT_EQUAL_INT32(65535, identify.turn.swing_ticks);
    steepen_from(300000, TOP - 3600); /* √(22485·2^32/2π/3600), where one of 22485 is 1.45 of it */
    TEST_ASSERT_EQUAL_INT32(65340, identify.turn.swing_ticks);
    steepen_from(10, 0);
    TEST_ASSERT_EQUAL_INT32(8, identify.turn.swing_ticks);
    TEST_ASSERT_EQUAL_INT32(DAMPING_MOST, word(PROBE_DAMPING));
    TEST_ASSERT_EQUAL_INT32(64, identify.turn.ramp_ticks);
}

/* Windows with 8/ω_n at both ends, 450 ms at most; a vector that has arrived is held. */
TEST(test_ramps_go_down_and_up_with_a_hold_behind_each)
{
    int32_t edge;

    begin_ramps(0.001);
    edge = 8 * identify.turn.swing_ticks;
    TEST_ASSERT_TRUE((edge > 1024) && (edge < (450 * MS)));
    for (uint32_t part = 0U; part < 4U; part++) {
        const bool down = part == 0U;

        answer_ramp(0.3);
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
        if ((part % 2U) == 0U) {
            TEST_ASSERT_EQUAL_STRING("ramp", identify.aim.kind);
            TEST_ASSERT_TRUE(identify.aim.leads);
            TEST_ASSERT_EQUAL_INT32(down ? (TOP / 2) : TOP, word(PROBE_SPEED));
            TEST_ASSERT_EQUAL_INT32((TOP - (TOP / 2)) / identify.turn.ramp_ticks, word(PROBE_RAMP));
            TEST_ASSERT_EQUAL_INT32(edge, identify.aim.settle);
            TEST_ASSERT_EQUAL_INT32(identify.turn.ramp_ticks + (2 * edge), identify.aim.ticks);
        } else {
            TEST_ASSERT_EQUAL_STRING("hold", identify.aim.kind);
            TEST_ASSERT_FALSE(identify.aim.leads);
            TEST_ASSERT_EQUAL_INT32(0, identify.aim.settle);
            TEST_ASSERT_EQUAL_INT32(80 * MS, identify.aim.ticks);
        }
    }
}

static void ramp_with(int32_t ramp, int32_t swing)
{
    identify.turn.ramp_ticks = ramp;
    identify.turn.swing_ticks = swing;
    identify.step = 0U;
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
}

TEST(test_the_ends_of_a_ramps_window_are_bounded)
{
    begin_ramps(0.3);
    ramp_with(100, 8);
    TEST_ASSERT_EQUAL_INT32(1024, identify.aim.settle);
    ramp_with(5000, 1000);
    TEST_ASSERT_EQUAL_INT32(450 * MS, identify.aim.settle);
    ramp_with(8000, 1); /* a swing that is known, whatever the ramp */
    TEST_ASSERT_EQUAL_INT32(1024, identify.aim.settle);
    ramp_with(8000, 0);
    TEST_ASSERT_EQUAL_INT32(2000, identify.aim.settle);
    identify.ms_ticks = 2; /* 900 ticks are fewer than 1024 */
    ramp_with(5000, 1000);
    TEST_ASSERT_EQUAL_INT32(1024, identify.aim.settle);
    identify.ms_ticks = 100; /* 45000 are more than a quarter of a window */
    ramp_with(5000, 5000);
    TEST_ASSERT_EQUAL_INT32(PROBE_WINDOW_MAX / 4, identify.aim.settle);
}

/* What friction takes is the same up and down: (0.4 + 0.2)/2 is enough. */
TEST(test_the_torque_of_a_pair_is_half_of_the_difference)
{
    begin_ramps(0.12);
    pair_of_ramps(-0.07, 0.17);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_INT32_WITHIN(60, (400 * MS * 2) / 5, identify.turn.ramp_ticks);
    pair_of_ramps(-0.2, 0.4);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
    TEST_ASSERT_INT32_WITHIN(60, (400 * MS * 2) / 5, identify.turn.ramp_ticks);
}

/* 2/3 of 0.3. */
TEST(test_ramps_become_as_steep_as_the_torque_allows)
{
    begin_ramps(0.15);
    pair_of_ramps(-0.198, 0.198);
    TEST_ASSERT_FALSE(identify.turn.steep);
    begin_ramps(0.15);
    pair_of_ramps(-0.202, 0.202);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
}

/* A current across of 1/8 of that along: 516 a tick in the mean of a ramp. */
static void across_in_the_next_pair(int32_t ramps)
{
    for (uint32_t part = 0U; part < 4U; part++) {
        answer_ramp((part == 1U) ? -0.01 : 0.01);
        sums()->current.q = ((part % 2U) == 1U) ? (-(CURRENT / 8) * ramps) : 0;
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    }
}

TEST(test_a_ramp_is_not_so_short_that_a_current_across_flows)
{
    begin_ramps(0.001); /* 2500 */
    across_in_the_next_pair(1900);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(1900, identify.turn.ramp_ticks);
    across_in_the_next_pair(1519); /* 5/4 of it are 1898 */
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(1519, identify.turn.ramp_ticks);
    across_in_the_next_pair(1216); /* 1520 */
    TEST_ASSERT_TRUE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(1519, identify.turn.ramp_ticks);
    begin_ramps(0.001);
    identify.turn.ramp_ticks = 1600;
    across_in_the_next_pair(1280);
    TEST_ASSERT_TRUE(identify.turn.steep);
}

TEST(test_without_a_current_each_one_across_counts)
{
    begin_ramps(0.001);
    *identify_aim_word(&identify, PROBE_CURRENT) = 0;
    for (uint32_t part = 0U; part < 4U; part++) {
        answer_ramp(0.0);
        sums()->current.q = 1900;
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    }
    TEST_ASSERT_EQUAL_INT32(1900, identify.turn.ramp_ticks);
}

TEST(test_a_ramp_has_64_ticks_at_least)
{
    begin_ramps(0.001);
    for (uint32_t k = 0U; (k < 12U) && !identify.turn.steep; k++) {
        pair_of_ramps(-0.001, 0.001);
    }
    TEST_ASSERT_EQUAL_INT32(64, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(3, identify.turn.pairs_left); /* 25000/5952 with the one before */
}

/* Of 64 ticks, 1024 at both ends, and a hold of 80 ms: so many pairs in 2.5 s, 2 to 9. */
static void expect_pairs(int32_t ms_ticks, int32_t ramp, int32_t pairs)
{
    begin_ramps(0.3);
    identify.ms_ticks = ms_ticks;
    identify.turn.ramp_ticks = ramp;
    identify.turn.swing_ticks = 8;
    pair_of_ramps(-0.3, 0.3);
    TEST_ASSERT_TRUE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(pairs - 1, identify.turn.pairs_left);
}

TEST(test_the_pairs_take_two_and_a_half_seconds)
{
    expect_pairs(10, 64, 4); /* 25000 / 5952 */
    expect_pairs(20, 64, 6); /* 50000 / 7552 */
    expect_pairs(40, 64, 9); /* 100000 / 10752 */
    expect_pairs(10, 5000, 2);
    expect_pairs(100, 64, 9);
    expect_pairs(100, 5000, 6); /* 250000 / 40096 */
    expect_pairs(20, 676, 5);   /* 50000 / 10000 */
    expect_pairs(20, 677, 4);
}

TEST(test_after_its_pairs_of_ramps_the_rotor_coasts)
{
    begin_ramps(0.3);
    pair_of_ramps(-0.3, 0.3);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
    pair_of_ramps(-0.01, 0.01); /* counts whatever its torque */
    TEST_ASSERT_EQUAL_INT32(0, identify.turn.pairs_left);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    answer_ramp(0.3);
    identify.aim.leads = true;
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_COAST, identify.phase);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

/* In the hold behind a ramp down, and behind one up. */
TEST(test_a_rotor_that_is_lost_in_a_ramp_is_caught)
{
    begin_ramps(0.3);
    (void)identify_turn_plan_ramp(&identify);
    answer_ramp(-0.3);
    (void)identify_turn_plan_ramp(&identify);
    answer_spin(500, ACROSS / 3, QUARTER);
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    assert_caught(1U);
    begin_ramps(0.3);
    pair_of_ramps(-0.3, 0.3);
    answer_spin(500, ACROSS / 3, QUARTER);
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    assert_caught(1U);
}

/* Nothing has been measured of a ramp yet. */
TEST(test_what_came_before_the_first_ramp_loses_no_rotor)
{
    begin_ramps(0.3);
    answer_spin(500, ACROSS / 3, QUARTER);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
}

static int32_t torque_down_of(probe_sums_t window)
{
    begin_ramps(0.3);
    identify.step = 1U;
    identify.aim.ticks = 10;
    identify.turn.ramp_ticks = 6000;
    *sums() = window;
    (void)identify_turn_plan_ramp(&identify);
    return identify.turn.torque_down;
}

/* 18000000 over a current of 3 and 6000 ticks are 1000; over a flux of 300, 3.33. */
TEST(test_a_torque_is_that_over_the_ramp_of_current_and_flux)
{
    probe_sums_t window = {
        .torque = 18000000, .current = {30, 0}, .turn_q16 = 1, .voltage = {0, 32 * 300}};

    TEST_ASSERT_EQUAL_INT32(54613, torque_down_of(window));
    window.torque = 6000000;
    window.current.d = 10;
    TEST_ASSERT_EQUAL_INT32(54613, torque_down_of(window));
}

/* A speed, a current and an EMF of nothing, as after a contact that opens. */
TEST(test_a_torque_of_no_motor_is_bounded)
{
    TEST_ASSERT_EQUAL_INT32(4 * 16384, torque_down_of((probe_sums_t){.torque = 1000}));
    TEST_ASSERT_EQUAL_INT32(-4 * 16384, torque_down_of((probe_sums_t){.torque = -1000}));
    TEST_ASSERT_EQUAL_INT32(4 * 16384, torque_down_of((probe_sums_t){.torque = INT32_MAX}));
    TEST_ASSERT_EQUAL_INT32(0, torque_down_of((probe_sums_t){.torque = 0}));
}

/* ---- COAST ---- */

static void begin_coast(void)
{
    setUp();
    begin_phase(IDENTIFY_COAST);
    identify.turn.top = TOP;
    identify_aim_current(&identify, CURRENT);
    identify_aim_window(&identify, "ramp", 0, 400); /* the last before */
    answer_spin(0, 0, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_coast(&identify));
}

static bool coast_at(step_t speed)
{
    answer_spin(0, 0, speed);
    return identify_turn_plan_coast(&identify);
}

static uint32_t coast(double fall)
{
    uint32_t windows = 1U;
    double speed = TOP;

    begin_coast();
    while (coast_at((step_t)speed) && (windows < 100U)) {
        windows++;
        speed *= fall;
    }
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
    return windows;
}

TEST(test_coasting_has_no_current_and_follows_the_rotor)
{
    begin_coast();
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(DAMPING_MOST, word(PROBE_DAMPING));
    TEST_ASSERT_EQUAL_INT32(300000, word(PROBE_TRACKING));
    TEST_ASSERT_TRUE(identify.aim.rushes);
    TEST_ASSERT_EQUAL_STRING("coast", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(60, identify.aim.settle);
    TEST_ASSERT_TRUE(coast_at(TOP));
    TEST_ASSERT_EQUAL_INT32(0, identify.aim.settle);
}

/* Four times as quick: its shift is less by two. */
TEST(test_coasting_has_a_quick_integral)
{
    int32_t quick;

    begin_coast();
    identify.rest.inductance_q16 = 1441;
    TEST_ASSERT_TRUE(coast_at(TOP));
    quick = word(PROBE_INTEGRAL_Q) >> 16;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((word(PROBE_INTEGRAL_Q) >> 16) - 2, quick);
}

/* An electrical turn at half of the speed, 300 ticks; 5 and 80 ms are its bounds. */
TEST(test_the_first_window_of_coasting_is_a_turn)
{
    static const struct {
        step_t top;
        int32_t ticks;
    } turns[] = {{TOP, 300}, {TOP * 20, 5 * MS}, {TOP / 3, 60 * MS}, {1, 60 * MS}};

    for (uint32_t k = 0U; k < 4U; k++) {
        setUp();
        begin_phase(IDENTIFY_COAST);
        identify.turn.top = turns[k].top;
        identify.aim.ticks = 400;
        TEST_ASSERT_TRUE(identify_turn_plan_coast(&identify));
        TEST_ASSERT_EQUAL_INT32(turns[k].ticks, identify.aim.ticks);
    }
}

/* The second window gives the speed that the later ones are compared with: until then none grows. */
TEST(test_windows_of_coasting_grow_once_there_is_a_speed_to_compare_with)
{
    static const int32_t ticks[] = {300, 300, 600, 600, 600};

    begin_coast();
    for (uint32_t k = 0U; k < 5U; k++) {
        TEST_ASSERT_TRUE(coast_at(TOP));
        TEST_ASSERT_EQUAL_INT32(ticks[k], identify.aim.ticks);
    }
}

/* In 2^-20 turns a tick: windows of 300 ticks, to the nearest that is not below. */
static bool coast_with(uint32_t step, int32_t speed)
{
    begin_coast();
    identify.step = step;
    identify.turn.coast_speed = 3495;
    identify.aim.ticks = 300;
    sums()->turn_q16 = ((speed * 300) + 15) / 16;
    return identify_turn_plan_coast(&identify);
}

/* By more than 1/64: 54. */
TEST(test_windows_of_coasting_stay_once_the_speed_falls)
{
    TEST_ASSERT_TRUE(coast_with(4U, 3495 - 54));
    TEST_ASSERT_EQUAL_INT32(300, identify.aim.ticks);
    TEST_ASSERT_TRUE(coast_with(4U, 3495 - 53));
    TEST_ASSERT_EQUAL_INT32(600, identify.aim.ticks);
}

TEST(test_a_window_of_60_ms_is_the_longest)
{
    begin_coast();
    (void)coast_at(TOP);
    (void)coast_at(TOP);
    identify.turn.coast_ticks = 60 * MS;
    (void)coast_at(TOP);
    TEST_ASSERT_EQUAL_INT32(60 * MS, identify.turn.coast_ticks);
}

/* The second window gives the speed that halves: 0.8^4 is below a half of it. */
TEST(test_coasting_ends_at_half_of_the_speed_or_after_its_windows)
{
    TEST_ASSERT_EQUAL_UINT32(19U, coast(1.0));
    TEST_ASSERT_EQUAL_INT32(600, identify.turn.coast_ticks);
    TEST_ASSERT_EQUAL_UINT32(6U, coast(0.8));
    TEST_ASSERT_EQUAL_INT32(300, identify.turn.coast_ticks);
}

TEST(test_coasting_ends_with_a_window_below_half_of_the_speed_the_third_or_later)
{
    TEST_ASSERT_TRUE(coast_with(3U, 1747));
    TEST_ASSERT_FALSE(coast_with(3U, 1746));
    begin_coast();
    TEST_ASSERT_TRUE(coast_at(TOP));
    TEST_ASSERT_TRUE(coast_at(TOP / 4)); /* of which the others are a share */
}
