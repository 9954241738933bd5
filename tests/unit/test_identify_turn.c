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
    start();
}

/* The means of the window that has ended, at so many steps a tick. */
static void answer_spin(int32_t along, int32_t across, step_t speed)
{
    const int32_t ticks = identify.aim.ticks;

    *sums() = (probe_sums_t){.voltage = {along * ticks, across * ticks}};
    sums()->current.d = word(PROBE_CURRENT) * ticks;
    sums()->turn_q16 = (int32_t)(((int64_t)speed * ticks) / 65536);
}

/* 512/2^16 of a turn are 16384 of Q15: the sum of the voltage is the flux. */
static void answer_flux(int32_t flux_q14)
{
    *sums() = (probe_sums_t){.turn_q16 = 512, .voltage = {0, flux_q14}};
}

/* ---- SPIN ---- */

static bool spin_after(int32_t along, int32_t across, step_t speed)
{
    answer_spin(along, across, speed);
    return identify_turn_plan_spin(&identify);
}

/* What the first plan asks for. */
static int32_t first_word(probe_word_t which)
{
    identify_aim_phase(&identify, IDENTIFY_SPIN);
    (void)identify_turn_plan_spin(&identify);
    return word(which);
}

static void begin_spinning(void)
{
    setUp();
    identify.rest = (identify_rest_t){
        .inductance_q16 = INDUCTANCE, .resistance_q13 = {1, 2, RESISTANCE}, .loss = 100};
    TEST_ASSERT_EQUAL_INT32(TOP / 4, first_word(PROBE_SPEED));
    identify.turn.swing_ticks = 77; /* of an attempt before */
}

/* 2000 at a quarter of the speed. */
static void spin_on(uint32_t step)
{
    static const int32_t across[] = {2000, 4000, 8000, 8000};
    static const step_t speed[] = {QUARTER, TOP / 2, TOP, TOP};

    while (identify.step < step) {
        TEST_ASSERT_TRUE(spin_after(500, across[identify.step - 1U], speed[identify.step - 1U]));
    }
}

static void spin_to(uint32_t step)
{
    begin_spinning();
    spin_on(step);
}

#define OUT_OF_STEP "the rotor falls out of step: is the load too large, or does it change?"
#define STANDS "the rotor does not turn with the current: is it blocked, braked, or loaded?"
#define TOO_LOW "the bus voltage is too low to turn the motor at 1/8 of its highest speed"

static identify_phase_t phase_after_quarter(int32_t along, int32_t across)
{
    begin_spinning();
    (void)spin_after(along, across, QUARTER);
    if (identify.phase == IDENTIFY_ENDS) {
        TEST_ASSERT_EQUAL_STRING(TOO_LOW, identify.why);
    }
    return identify.phase;
}

static void assert_caught(uint32_t times)
{
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    TEST_ASSERT_EQUAL_UINT32(times, identify.turn.slower);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

/* What each of three attempts shows, in ramps that were steep, is that of a lost rotor. */
static void lose_thrice(uint32_t step, int32_t along, int32_t across, const char *why)
{
    for (uint32_t lost = 0U; lost < 3U; lost++) {
        spin_to(step);
        identify.turn.slower = lost;
        identify.turn.steep = true;
        identify.aim.leads = true;
        TEST_ASSERT_FALSE(spin_after(along, across, (step == 1U) ? QUARTER : TOP));
        if (lost < 2U) {
            assert_caught(lost + 1U);
        } else {
            assert_refused(why);
        }
    }
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
    identify.rest.inductance_q16 = 3000000;
    TEST_ASSERT_EQUAL_INT32(32767, first_word(PROBE_REACTANCE));
    identify.rest.resistance_q13[2] = 700; /* R·i is 352, less than twice the loss */
    TEST_ASSERT_EQUAL_INT32(200, first_word(PROBE_EMF));
    identify.rest.resistance_q13[2] = 32767; /* 16511 */
    TEST_ASSERT_EQUAL_INT32(8255, first_word(PROBE_EMF));
}

/* From rest to the highest speed in 2 s. */
TEST(test_the_vector_reaches_a_quarter_and_half_of_the_speed_on_a_gentle_ramp)
{
    begin_spinning();
    TEST_ASSERT_EQUAL_INT32(TOP / (2000 * MS), word(PROBE_RAMP));
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(150 * MS, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(80 * MS, identify.aim.ticks);
    TEST_ASSERT_FALSE(identify.aim.leads);
    spin_on(2U);
    TEST_ASSERT_EQUAL_INT32(TOP / 2, word(PROBE_SPEED));
    TEST_ASSERT_EQUAL_INT32(TOP / (2000 * MS), word(PROBE_RAMP));
}

TEST(test_each_further_attempt_has_half_of_the_slope_and_any_speed_has_one)
{
    for (uint32_t slower = 0U; slower < 3U; slower++) {
        identify.turn.slower = slower;
        TEST_ASSERT_EQUAL_INT32(TOP / ((2000 * MS) << slower), first_word(PROBE_RAMP));
    }
    identify.turn.slower = 0U;
    cfg.speed_loop.speed_max = 0x20000000;
    TEST_ASSERT_EQUAL_INT32(0x10000000 / 20000, first_word(PROBE_RAMP));
    cfg.speed_loop.speed_max = 40000;
    TEST_ASSERT_EQUAL_INT32(1, first_word(PROBE_RAMP));
}

/*
 * 12/16 of 0.5485 of the bus, 9286: with 3000 across at a quarter of it 9272/3000 of that are
 * there.
 */
TEST(test_the_highest_speed_is_that_for_which_the_bus_is_there)
{
    const double lsb = QUARTER / 3000.0;

    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(500, 3000));
    TEST_ASSERT_DOUBLE_WITHIN(lsb, 9272.0 * lsb, identify.turn.top);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(-8000, 3000)); /* with a lag */
    TEST_ASSERT_DOUBLE_WITHIN(lsb, 4714.9 * lsb, identify.turn.top);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(500, 2000));
    TEST_ASSERT_EQUAL_INT32(TOP, identify.turn.top);
}

static identify_phase_t phase_with(int32_t inductance_q16, int32_t flux_q14)
{
    begin_spinning();
    identify.rest.inductance_q16 = inductance_q16;
    answer_flux(flux_q14);
    (void)identify_turn_plan_spin(&identify);
    return identify.phase;
}

/*
 * 1/20 of the voltage at the highest speed: 12382/20 at 13981 is a flux of 725, and 4 are L·i; 77.7
 * at 1747.
 */
TEST(test_a_rotor_that_does_not_turn_has_no_emf)
{
    /* a highest speed below one of Q15 counts as one: 1/20 of the voltage is a flux of 619 */
    cfg.speed_loop.speed_max = 2000;
    for (int32_t k = 0; k < 2; k++) {
        (void)first_word(PROBE_SPEED);
        *sums() = (probe_sums_t){.turn_q16 = 1, .voltage = {0, 19811 + k}}; /* 32 of 619.1 */
        (void)identify_turn_plan_spin(&identify);
        TEST_ASSERT_EQUAL((k == 0) ? IDENTIFY_CATCH : IDENTIFY_SPIN, identify.phase);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_quarter(500, 60));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_quarter(500, 77));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(500, 78));
    /* it turns the other way */
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_quarter(500, -3000));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_with(INDUCTANCE, 725 + 3));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_with(INDUCTANCE, 725 + 4));
}

/*
 * Of 100 times the inductance L·i is 442: 1768 of Q13 times 4128/2^14. Of 1000 times it is 4420,
 * and 1/4 of that above it counts.
 */
TEST(test_the_voltage_of_the_inductance_is_no_emf)
{
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_with(100 * INDUCTANCE, 442 + 724));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_with(100 * INDUCTANCE, 442 + 725));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_with(1000 * INDUCTANCE, 4420 + 1104));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_with(1000 * INDUCTANCE, 4420 + 1105));
}

/* A heavy rotor follows a slower way to this speed. */
TEST(test_a_rotor_that_is_left_behind_is_caught_twice_and_then_refused)
{
    lose_thrice(1U, 500, 60, STANDS);
}

/* 1/16 is half of a quarter of half: 1500 of 3000 have to be left. */
TEST(test_a_bus_that_is_too_low_is_refused)
{
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_after_quarter(9200, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_after_quarter(20000, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_after_quarter(9180, 3000)); /* 1398 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(9150, 3000)); /* 1584 */
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_after_quarter(0, 18590));   /* half of it are 9295 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_after_quarter(0, 18550));
    /* a rotor that stands does so whatever voltage is left */
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_quarter(20000, 60));
}

/* 12382 is the limit: 1/32 of it is left, 386. */
TEST(test_a_bus_whose_whole_voltage_is_used_is_too_low)
{
    static const dq_t used[] = {{0, 11996}, {0, 11997}, {-11997, 0}};

    for (uint32_t k = 0U; k < 3U; k++) {
        begin_spinning();
        app.drive.control.voltage = used[k];
        TEST_ASSERT_EQUAL(k == 0U, spin_after(500, 2000, QUARTER));
        TEST_ASSERT_EQUAL_STRING((k == 0U) ? NULL : TOO_LOW, identify.why);
    }
    TEST_ASSERT_FALSE(identify_turn_lacks_voltage(&identify)); /* it is said already */
}

static bool lacks_voltage_in(identify_phase_t phase, uint32_t step)
{
    identify.phase = phase;
    identify.step = step;
    return identify_turn_lacks_voltage(&identify);
}

/* Later on the speed is bounded by what it has taken. */
TEST(test_the_whole_voltage_counts_at_a_quarter_of_the_speed_only)
{
    app.drive.control.voltage = (dq_t){0, 12382};
    TEST_ASSERT_TRUE(lacks_voltage_in(IDENTIFY_SPIN, 1U));
    TEST_ASSERT_FALSE(lacks_voltage_in(IDENTIFY_SPIN, 0U));
    TEST_ASSERT_FALSE(lacks_voltage_in(IDENTIFY_SPIN, 2U));
    TEST_ASSERT_FALSE(lacks_voltage_in(IDENTIFY_RAMP, 1U));
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
    spin_on(4U);
    TEST_ASSERT_FALSE(identify.aim.leads);
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_TRUE(identify.turn.swing_ticks > 100);
    TEST_ASSERT_EQUAL_INT32((150 * MS) + (8 * identify.turn.swing_ticks), identify.aim.settle);
}

static void expect_first_ramp(uint32_t slower, int32_t ticks, int32_t edge, step_t low, step_t ramp)
{
    identify.turn.slower = slower;
    TEST_ASSERT_TRUE(spin_after(500, 2000, QUARTER));
    TEST_ASSERT_EQUAL_INT32(ticks, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(low, identify.turn.low);
    TEST_ASSERT_EQUAL_INT32(low, word(PROBE_SPEED));
    TEST_ASSERT_TRUE(spin_after(500, 4000, low));
    TEST_ASSERT_EQUAL_INT32(ramp, word(PROBE_RAMP));
    TEST_ASSERT_EQUAL_INT32(edge, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(ticks + (2 * edge), identify.aim.ticks);
}

/*
 * A quarter of its time would be 500 ms. At 100 kHz the 4 s of a third attempt have three times
 * the ticks of a window: half of a window is the ramp's, which begins at a higher speed.
 */
TEST(test_the_first_ramp_of_a_further_attempt_has_half_of_the_slope_and_fits_its_window)
{
    const step_t slope = (TOP - (TOP / 2)) / 400000;
    const int32_t ticks = PROBE_WINDOW_MAX / 2;

    begin_spinning();
    expect_first_ramp(1U, 2000 * MS, 450 * MS, TOP / 2, (TOP - (TOP / 2)) / (2000 * MS));
    begin_spinning();
    identify.ms_ticks = 100;
    expect_first_ramp(2U, ticks, ticks / 4, TOP - (slope * ticks), slope);
}

/*
 * A low bus leaves 1791690 of the highest speed, half of which is far below the quarter where that
 * shows: 3.0 s in a first attempt, and twice as much in each further one. A vector that takes 5 s,
 * and twice as much, is lost (identify.c).
 */
TEST(test_no_vector_moves_so_long_as_one_that_is_lost)
{
    for (uint32_t slower = 0U; slower < 3U; slower++) {
        begin_spinning();
        identify.turn.slower = slower;
        TEST_ASSERT_TRUE(spin_after(0, 18550, QUARTER));
        TEST_ASSERT_EQUAL_INT32(1791690 / 2, word(PROBE_SPEED));
        const int32_t ticks = (QUARTER - (1791690 / 2)) / word(PROBE_RAMP);
        TEST_ASSERT_TRUE(ticks > ((3000 * MS) << slower));
        TEST_ASSERT_TRUE(ticks < ((5000 * MS) << slower));
    }
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
TEST(test_the_flux_is_voltage_over_speed_at_half_of_the_speed)
{
    spin_to(2U);
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

TEST(test_half_of_the_current_comes_last)
{
    spin_to(5U);
    TEST_ASSERT_EQUAL_INT32(CURRENT / 2, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_STRING("spin", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32((150 * MS) + (8 * identify.turn.swing_ticks), identify.aim.settle);
    TEST_ASSERT_FALSE(spin_after(500, 8000, TOP));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    TEST_ASSERT_EQUAL_INT32(CURRENT, word(PROBE_CURRENT));
}

/*
 * Of half of the current R·i is 389, and the legs lose 100: what is above it along the current is
 * EMF.
 */
static identify_phase_t phase_after_half(int32_t emf_d, int32_t emf_q)
{
    spin_to(5U);
    TEST_ASSERT_FALSE(spin_after(389 + 100 + emf_d, emf_q, TOP));
    return identify.phase;
}

/* By more than 3/8 of 8000: the current halves the L·i of a standing rotor, but not an EMF. */
TEST(test_a_rotor_whose_emf_falls_with_the_current_has_stood)
{
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_half(0, 4990));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_after_half(0, 5010));
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
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_half(3980, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_after_half(4015, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_half(-3980, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_after_half(-4015, 3000));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_after_half(4015, 0));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_after_half(10000, 200));
}

/* Of the largest resistance R·i is 8255 at half of the current. */
static identify_phase_t phase_of_lag(int32_t whole_q14, int32_t emf_d, int32_t emf_q)
{
    spin_to(5U);
    identify.rest.resistance_q13[2] = 32767;
    identify.turn.flux_q14 = whole_q14;
    (void)spin_after(8255 + 100 + emf_d, emf_q, TOP);
    return identify.phase;
}

/*
 * A flux of 2.34 for a volt. Voltages end at 16 bits: |e| is 32829 and 32767, 8/5 of these fluxes
 * 123110 and 122754. None across counts as 1: 15·2. A lag ends at 32: 32767/1024·2 are 63.998.
 */
TEST(test_the_emf_of_a_lag_has_its_bounds)
{
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_of_lag(122000, -41122, 2000));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_of_lag(124000, -41122, 2000));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_of_lag(122000, 0, 40000));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_of_lag(124000, 0, 40000));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_of_lag(48, 15, 1));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_of_lag(49, 15, 1));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, phase_of_lag(101, 100, 1));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_of_lag(102, 100, 1));
}

/* A rotor whose axes have unlike L is found there only. */
TEST(test_a_rotor_that_has_stood_is_caught_twice_and_then_refused)
{
    lose_thrice(5U, 389 + 100, 4990, STANDS);
}

/* At the whole current R·i is 779, and the legs lose 100. Of the largest R it is 16511. */
static bool is_loaded(int32_t resistance_q13, int32_t emf_d)
{
    spin_to(4U);
    identify.rest.resistance_q13[2] = resistance_q13;
    TEST_ASSERT_TRUE(
        spin_after(((resistance_q13 == RESISTANCE) ? 779 : 16511) + 100 + emf_d, 8192, TOP));
    TEST_ASSERT_EQUAL_INT32(identify.turn.loaded ? CONTINUOUS : (CURRENT / 2), word(PROBE_CURRENT));
    return identify.turn.loaded;
}

/* |e| over e_q beyond 1093/1024: beside 8192 across that is 8752, from 3081 along on. */
TEST(test_a_rotor_that_lags_by_20_degrees_has_the_continuous_current)
{
    TEST_ASSERT_FALSE(is_loaded(RESISTANCE, 3080));
    TEST_ASSERT_TRUE(is_loaded(RESISTANCE, 3081));
    TEST_ASSERT_FALSE(is_loaded(RESISTANCE, -3080));
    TEST_ASSERT_TRUE(is_loaded(RESISTANCE, -3081));
    TEST_ASSERT_FALSE(is_loaded(32767, 3080));
    TEST_ASSERT_TRUE(is_loaded(32767, 3081));
}

/* Its EMF falls with the lag, whatever it is. The ramps keep its current. */
TEST(test_a_loaded_rotor_is_not_asked_whether_it_has_stood)
{
    TEST_ASSERT_TRUE(is_loaded(RESISTANCE, 4000));
    TEST_ASSERT_FALSE(spin_after(0, 100, TOP));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
    answer_spin(500, 8000, TOP);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
}

/* Its slower ramps may leave more of the torque to friction. */
TEST(test_a_further_attempt_asks_for_the_load_anew)
{
    TEST_ASSERT_TRUE(is_loaded(RESISTANCE, 4000));
    identify_turn_catch_again(&identify);
    TEST_ASSERT_EQUAL_INT32(CURRENT, first_word(PROBE_CURRENT));
    spin_on(5U);
    TEST_ASSERT_FALSE(identify.turn.loaded);
    TEST_ASSERT_EQUAL_INT32(CURRENT / 2, word(PROBE_CURRENT));
    TEST_ASSERT_FALSE(spin_after(389 + 100, 4990, TOP));
    assert_caught(2U);
}

/* Half of the flux of before is the least. */
TEST(test_a_rotor_out_of_step_is_caught_twice_and_then_refused)
{
    lose_thrice(4U, 500, 3990, OUT_OF_STEP);
    spin_to(4U);
    TEST_ASSERT_TRUE(spin_after(500, 4010, TOP));
    spin_to(4U);
    identify.turn.flux_q14 = 200; /* half of it is as large as what shows */
    answer_flux(100);
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    spin_to(3U); /* the mean of the first ramp is no EMF of one speed */
    TEST_ASSERT_TRUE(spin_after(500, 100, TOP));
}

/* ---- RAMP ---- */

#define ACROSS (2000) /* at a quarter of the speed */

/* A torque over what the current can pull, as a share of the flux that shows. */
static void answer_ramp(double share)
{
    const double flux = ACROSS / (QUARTER / 2048.0);
    const double current = word(PROBE_CURRENT);

    answer_spin(500, (int32_t)(((double)identify.turn.top / QUARTER) * ACROSS), identify.turn.top);
    app.drive.probe.own_speed = identify.turn.low; /* a ramp down has come there */
    sums()->torque = (int32_t)(share * flux * current * identify.turn.ramp_ticks);
}

static void begin_ramps(double share)
{
    spin_to(2U);
    do {
        answer_ramp(share);
    } while (identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

/* One pair: down, hold, up, hold. `across`: the sum of the current across in each ramp. */
static void pair_with(double down, double up, int32_t across)
{
    for (uint32_t part = 0U; part < 4U; part++) {
        answer_ramp((part == 1U) ? down : up);
        sums()->current.q = ((part % 2U) == 1U) ? across : 0;
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    }
}

static void pair_of_ramps(double share)
{
    pair_with(-share, share, 0);
}

/* The rotor that would turn with 2000 across has a third of that. */
static void lose_in_ramp(void)
{
    answer_spin(500, ACROSS / 3, QUARTER);
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    assert_caught(1U);
}

/*
 * 0.3 lets the rotor lag enough: 1 s stays, but 400 ms are the longest ramp, from 4/5 of the speed.
 * 2/5 of the torque: 2/5 of the time, 1/ω_n² = T·0.12/Δω in radians. A quarter counts at least.
 */
TEST(test_the_next_ramp_is_up_to_four_times_as_steep_as_the_first_has_little_torque)
{
    begin_ramps(0.3);
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_INT32_WITHIN(TOP / 1000, (TOP / 5) * 4, identify.turn.low);
    begin_ramps(0.12);
    TEST_ASSERT_INT32_WITHIN(120, 400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_TRUE(identify.turn.ramp_ticks < (400 * MS));
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    TEST_ASSERT_INT32_WITHIN(1, 338, identify.turn.swing_ticks); /* √(1200·2^32/2π/7158279) */
    TEST_ASSERT_EQUAL_INT32((2 * 683565276) / identify.turn.swing_ticks, word(PROBE_DAMPING));
    begin_ramps(0.001);
    TEST_ASSERT_INT32_WITHIN(50, (1000 * MS) / 4, identify.turn.ramp_ticks);
    TEST_ASSERT_INT32_WITHIN(1, 267, identify.turn.swing_ticks);
    begin_ramps(-0.3);
    TEST_ASSERT_INT32_WITHIN(50, (1000 * MS) / 4, identify.turn.ramp_ticks);
}

/* The swing after a first ramp that ends with no torque: 1228 of 2^14 count. */
static int32_t swing_after(int32_t ramp, step_t low)
{
    spin_to(3U);
    identify.turn.ramp_ticks = ramp;
    identify.turn.low = low;
    spin_on(4U);
    return identify.turn.swing_ticks;
}

/*
 * 1228 of 2^14 are 76 of the 307 that are enough: 16158 becomes 4000. A longer one ends its slope
 * above half of the speed.
 */
TEST(test_a_ramp_of_more_than_400_ms_goes_less_far_down)
{
    (void)swing_after(16158, TOP / 2);
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP / 2, identify.turn.low);
    (void)swing_after(16162, TOP / 2); /* 4001 */
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(TOP - (((TOP - (TOP / 2)) / 4001) * 4000), identify.turn.low);
    spin_to(3U);
    identify.ms_ticks = 200; /* 400 ms would not fit their window */
    identify.turn.ramp_ticks = 300000;
    spin_on(4U);
    TEST_ASSERT_EQUAL_INT32(PROBE_WINDOW_MAX / 2, identify.turn.ramp_ticks);
}

TEST(test_the_swing_of_any_ramp_has_its_bounds)
{
    /* √(899·2^32/2π/7158279) is 292.99; of no change of the speed it is √(4·2^32/2π) */
    TEST_ASSERT_EQUAL_INT32(292, swing_after(12000, TOP / 2));
    TEST_ASSERT_EQUAL_INT32(52290, swing_after(64, TOP));
    TEST_ASSERT_EQUAL_INT32(65535, swing_after(12000, TOP)); /* its square beyond 32 bits */
    /* √(22485·2^32/2π/3600), where one of 22485 is 1.45 of it */
    TEST_ASSERT_EQUAL_INT32(65340, swing_after(300000, TOP - 3600));
    TEST_ASSERT_EQUAL_INT32(8, swing_after(10, 0));
    TEST_ASSERT_EQUAL_INT32(DAMPING_MOST, word(PROBE_DAMPING));
    TEST_ASSERT_EQUAL_INT32(64, identify.turn.ramp_ticks);
}

/* Windows with 8/ω_n at both ends, 450 ms at most; a vector that has arrived is held. */
TEST(test_ramps_go_down_and_up_with_a_hold_behind_each)
{
    begin_ramps(0.001);
    const int32_t edge = 8 * identify.turn.swing_ticks;
    const step_t slope = (TOP - (TOP / 2)) / identify.turn.ramp_ticks;
    TEST_ASSERT_TRUE((edge > 1024) && (edge < (450 * MS)));
    for (uint32_t part = 0U; part < 4U; part++) {
        const bool ramps = (part % 2U) == 0U;

        answer_ramp(0.3);
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
        TEST_ASSERT_EQUAL(ramps, identify.aim.leads);
        TEST_ASSERT_EQUAL_STRING(ramps ? "ramp" : "hold", identify.aim.kind);
        TEST_ASSERT_EQUAL_INT32((part < 2U) ? (TOP / 2) : TOP, word(PROBE_SPEED));
        TEST_ASSERT_EQUAL_INT32(slope, word(PROBE_RAMP));
        TEST_ASSERT_EQUAL_INT32(ramps ? edge : 0, identify.aim.settle);
        TEST_ASSERT_EQUAL_INT32(ramps ? (identify.turn.ramp_ticks + (2 * edge)) : (80 * MS),
                                identify.aim.ticks);
    }
}

static int32_t edge_of(int32_t ms_ticks, int32_t ramp, int32_t swing)
{
    identify.ms_ticks = ms_ticks;
    identify.turn.ramp_ticks = ramp;
    identify.turn.swing_ticks = swing;
    identify.step = 0U;
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    return identify.aim.settle;
}

TEST(test_the_ends_of_a_ramps_window_are_bounded)
{
    begin_ramps(0.3);
    TEST_ASSERT_EQUAL_INT32(1024, edge_of(10, 100, 8));
    TEST_ASSERT_EQUAL_INT32(450 * MS, edge_of(10, 5000, 1000));
    TEST_ASSERT_EQUAL_INT32(1024, edge_of(10, 8000, 1)); /* a known swing, whatever the ramp */
    TEST_ASSERT_EQUAL_INT32(2000, edge_of(10, 8000, 0));
    TEST_ASSERT_EQUAL_INT32(1024, edge_of(2, 5000, 1000)); /* 900 ticks are fewer than 1024 */
    /* 45000 are more than a quarter of a window */
    TEST_ASSERT_EQUAL_INT32(PROBE_WINDOW_MAX / 4, edge_of(100, 5000, 5000));
}

/* 2/3 of 0.3. What friction takes is the same up and down: (0.4 + 0.2)/2 is enough. */
TEST(test_ramps_become_as_steep_as_the_torque_allows)
{
    begin_ramps(0.12);
    pair_with(-0.07, 0.17, 0);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_INT32_WITHIN(60, (400 * MS * 2) / 5, identify.turn.ramp_ticks);
    pair_with(-0.2, 0.4, 0);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
    TEST_ASSERT_INT32_WITHIN(60, (400 * MS * 2) / 5, identify.turn.ramp_ticks);
    begin_ramps(0.15);
    pair_of_ramps(0.198);
    TEST_ASSERT_FALSE(identify.turn.steep);
    begin_ramps(0.15);
    pair_of_ramps(0.202);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
}

static void expect_ramp_across(int32_t across, bool steep, int32_t ramp)
{
    pair_with(-0.01, 0.01, across);
    TEST_ASSERT_EQUAL(steep, identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(ramp, identify.turn.ramp_ticks);
}

/* A current across of 1/8 of that along: 516 a tick in the mean of a ramp. */
TEST(test_a_ramp_is_not_so_short_that_a_current_across_flows)
{
    begin_ramps(0.001); /* 2500 */
    expect_ramp_across(-516 * 1900, false, 1900);
    expect_ramp_across(-516 * 1519, false, 1519); /* 5/4 of it are 1898 */
    expect_ramp_across(-516 * 1216, true, 1519);  /* 1520 */
    begin_ramps(0.001);
    identify.turn.ramp_ticks = 1600;
    expect_ramp_across(-516 * 1280, true, 1600);
    begin_ramps(0.001);
    identify_aim_set(&identify, PROBE_CURRENT, 0); /* each one across counts */
    expect_ramp_across(1900, false, 1900);
}

TEST(test_a_ramp_has_64_ticks_at_least)
{
    begin_ramps(0.001);
    for (uint32_t k = 0U; (k < 12U) && !identify.turn.steep; k++) {
        pair_of_ramps(0.001);
    }
    TEST_ASSERT_EQUAL_INT32(64, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(3, identify.turn.pairs_left); /* 25000/5952 with the one before */
}

/* The vector is above the low speed when the window of the ramp down ends. */
static void wait_for_bus(double share)
{
    answer_ramp(share);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    answer_ramp(-share);
    app.drive.probe.own_speed = identify.turn.low + 1;
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    for (uint32_t part = 2U; part < 4U; part++) {
        answer_ramp(share);
        TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    }
}

TEST(test_ramps_that_the_bus_does_not_bear_take_twice_as_long_or_go_half_as_far)
{
    begin_ramps(0.3);
    identify.turn.ramp_ticks = 1000;
    wait_for_bus(0.3);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(2000, identify.turn.ramp_ticks);
    pair_of_ramps(0.15);
    TEST_ASSERT_TRUE(identify.turn.steep);
    begin_ramps(0.3); /* of 400 ms, the longest */
    const step_t down = identify.turn.top - identify.turn.low;
    wait_for_bus(0.3);
    TEST_ASSERT_EQUAL_INT32(400 * MS, identify.turn.ramp_ticks);
    TEST_ASSERT_INT32_WITHIN(400 * MS, down / 2, identify.turn.top - identify.turn.low);
    pair_of_ramps(0.15);
    TEST_ASSERT_TRUE(identify.turn.steep);
}

/* Such as on a bus that the pairs before have charged. */
TEST(test_a_steep_ramp_that_the_bus_does_not_bear_takes_twice_as_long_too)
{
    int32_t before;

    begin_ramps(0.3);
    identify.turn.ramp_ticks = 1000;
    pair_of_ramps(0.3);
    TEST_ASSERT_TRUE(identify.turn.steep);
    before = identify.turn.ramp_ticks;
    wait_for_bus(0.3);
    TEST_ASSERT_FALSE(identify.turn.steep);
    TEST_ASSERT_EQUAL_INT32(2 * before, identify.turn.ramp_ticks);
}

/* Of 64 ticks, 1024 at both ends, and a hold of 80 ms. */
static int32_t pairs_of(int32_t ms_ticks, int32_t ramp)
{
    begin_ramps(0.3);
    identify.ms_ticks = ms_ticks;
    identify.turn.ramp_ticks = ramp;
    identify.turn.swing_ticks = 8;
    pair_of_ramps(0.3);
    TEST_ASSERT_TRUE(identify.turn.steep);
    return 1 + identify.turn.pairs_left;
}

TEST(test_the_pairs_take_two_and_a_half_seconds_and_are_2_to_9)
{
    TEST_ASSERT_EQUAL_INT32(4, pairs_of(10, 64)); /* 25000 / 5952 */
    TEST_ASSERT_EQUAL_INT32(6, pairs_of(20, 64)); /* 50000 / 7552 */
    TEST_ASSERT_EQUAL_INT32(9, pairs_of(40, 64)); /* 100000 / 10752 */
    TEST_ASSERT_EQUAL_INT32(2, pairs_of(10, 5000));
    TEST_ASSERT_EQUAL_INT32(9, pairs_of(100, 64));
    TEST_ASSERT_EQUAL_INT32(6, pairs_of(100, 5000)); /* 250000 / 40096 */
    TEST_ASSERT_EQUAL_INT32(5, pairs_of(20, 676));   /* 50000 / 10000 */
    TEST_ASSERT_EQUAL_INT32(4, pairs_of(20, 677));
}

TEST(test_after_its_pairs_of_ramps_the_rotor_coasts)
{
    begin_ramps(0.3);
    pair_of_ramps(0.3);
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
    pair_of_ramps(0.01); /* counts whatever its torque */
    TEST_ASSERT_EQUAL_INT32(0, identify.turn.pairs_left);
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
    answer_ramp(0.3);
    identify.aim.leads = true;
    TEST_ASSERT_FALSE(identify_turn_plan_ramp(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_COAST, identify.phase);
    TEST_ASSERT_FALSE(identify.aim.leads);
}

/* In the hold behind a ramp down, and behind one up. Before the first ramp nothing is measured. */
TEST(test_a_rotor_that_is_lost_in_a_ramp_is_caught)
{
    begin_ramps(0.3);
    answer_spin(500, ACROSS / 3, QUARTER);
    TEST_ASSERT_TRUE(identify_turn_plan_ramp(&identify));
    answer_ramp(-0.3);
    (void)identify_turn_plan_ramp(&identify);
    lose_in_ramp();
    begin_ramps(0.3);
    pair_of_ramps(0.3);
    lose_in_ramp();
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

/* ±4 at most: without speed, current and EMF, as after a contact that opens. */
TEST(test_a_torque_is_that_over_the_ramp_of_current_and_flux)
{
    /* 18000000 over a current of 3 and 6000 ticks are 1000; over a flux of 300, 3.33 */
    probe_sums_t window = {
        .torque = 18000000, .current = {30, 0}, .turn_q16 = 1, .voltage = {0, 32 * 300}};

    TEST_ASSERT_EQUAL_INT32(54613, torque_down_of(window));
    window.torque = 6000000;
    window.current.d = 10;
    TEST_ASSERT_EQUAL_INT32(54613, torque_down_of(window));
    TEST_ASSERT_EQUAL_INT32(4 * 16384, torque_down_of((probe_sums_t){.torque = 1000}));
    TEST_ASSERT_EQUAL_INT32(-4 * 16384, torque_down_of((probe_sums_t){.torque = -1000}));
    TEST_ASSERT_EQUAL_INT32(4 * 16384, torque_down_of((probe_sums_t){.torque = INT32_MAX}));
    TEST_ASSERT_EQUAL_INT32(0, torque_down_of((probe_sums_t){.torque = 0}));
}

/* ---- COAST ---- */

static void begin_coast(void)
{
    setUp();
    identify_aim_phase(&identify, IDENTIFY_COAST);
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

static void expect_coasting(double fall, uint32_t windows, int32_t ticks)
{
    double speed = TOP;
    uint32_t coasted = 1U;

    begin_coast();
    while (coast_at((step_t)speed) && (coasted < 100U)) {
        coasted++;
        speed *= fall;
    }
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
    TEST_ASSERT_EQUAL_UINT32(windows, coasted);
    TEST_ASSERT_EQUAL_INT32(ticks, identify.turn.coast_ticks);
}

/* Its integral is four times as quick: its shift is less by two. */
TEST(test_coasting_has_no_current_and_follows_the_rotor)
{
    begin_coast();
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(DAMPING_MOST, word(PROBE_DAMPING));
    TEST_ASSERT_EQUAL_INT32(300000, word(PROBE_TRACKING));
    TEST_ASSERT_TRUE(identify.aim.rushes);
    TEST_ASSERT_EQUAL_STRING("coast", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(60, identify.aim.settle);
    identify.rest.inductance_q16 = INDUCTANCE;
    TEST_ASSERT_TRUE(coast_at(TOP));
    TEST_ASSERT_EQUAL_INT32(0, identify.aim.settle);
    const int32_t quick = word(PROBE_INTEGRAL_Q) >> 16;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((word(PROBE_INTEGRAL_Q) >> 16) - 2, quick);
}

/* An electrical turn at half of the speed, 300 ticks; 5 and 80 ms are its bounds. */
TEST(test_the_first_window_of_coasting_is_a_turn)
{
    static const step_t tops[] = {TOP, TOP * 20, TOP / 3, 1};
    static const int32_t ticks[] = {300, 5 * MS, 60 * MS, 60 * MS};

    for (uint32_t k = 0U; k < 4U; k++) {
        identify_aim_phase(&identify, IDENTIFY_COAST);
        identify.turn.top = tops[k];
        identify.aim.ticks = 400;
        TEST_ASSERT_TRUE(identify_turn_plan_coast(&identify));
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

/* The second one gives the speed to compare with. One that is less by more than 1/64, 54, falls. */
TEST(test_windows_of_coasting_grow_until_the_speed_falls)
{
    static const int32_t ticks[] = {300, 300, 600, 600, 600};

    begin_coast();
    for (uint32_t k = 0U; k < 5U; k++) {
        TEST_ASSERT_TRUE(coast_at(TOP));
        TEST_ASSERT_EQUAL_INT32(ticks[k], identify.aim.ticks);
    }
    TEST_ASSERT_TRUE(coast_with(4U, 3495 - 54));
    TEST_ASSERT_EQUAL_INT32(300, identify.aim.ticks);
    TEST_ASSERT_TRUE(coast_with(4U, 3495 - 53));
    TEST_ASSERT_EQUAL_INT32(600, identify.aim.ticks);
}

/* The second window gives the speed: 0.8^4 is below half of it. 60 ms are the longest window. */
TEST(test_coasting_ends_at_half_of_the_speed_or_after_its_windows)
{
    expect_coasting(1.0, 19U, 60 * MS);
    expect_coasting(0.8, 6U, 300);
    TEST_ASSERT_TRUE(coast_with(3U, 1747));
    TEST_ASSERT_FALSE(coast_with(3U, 1746));
    begin_coast();
    TEST_ASSERT_TRUE(coast_at(TOP));
    TEST_ASSERT_TRUE(coast_at(TOP / 4)); /* the second window ends nothing */
}

/* ---- HALL ---- */

static drive_cfg_t with_halls;
static shaft_decoder_t shaft;

/* COAST has ended. */
static void begin_hall(void)
{
    begin_coast();
    with_halls = *app.drive.cfg;
    with_halls.sensor.kind = (uint32_t)SENSOR_KIND_HALL;
    app.drive.cfg = &with_halls;
    app_sense(&app, &shaft);
    identify.turn.swing_ticks = 100;
    identify.step = 3U;
    identify.turn.coast_speed = 3495;
    TEST_ASSERT_FALSE(coast_at(TOP / 4));
}

TEST(test_only_hall_sensors_that_are_read_follow_the_coasting)
{
    begin_hall();
    TEST_ASSERT_EQUAL(IDENTIFY_HALL, identify.phase);
    begin_hall();
    app.shaft = NULL;
    identify_aim_phase(&identify, IDENTIFY_COAST);
    identify.step = 3U;
    TEST_ASSERT_FALSE(coast_at(TOP / 4));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    begin_hall();
    with_halls.sensor.kind = (uint32_t)SENSOR_KIND_ENCODER;
    identify_aim_phase(&identify, IDENTIFY_COAST);
    identify.step = 3U;
    TEST_ASSERT_FALSE(coast_at(TOP / 4));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
}

/* A turn at half of the speed takes 600 ticks: here 600 and 5/8. 200 ms are 2000 ticks. */
TEST(test_the_vector_turns_twice_backwards_and_twice_forwards_for_the_hall_sensors)
{
    const double turn_ticks = 600.625;
    const int32_t shaft_ticks = (int32_t)(turn_ticks * ABOUT.rotation.pole_pairs);
    const int32_t turns = (2000 + shaft_ticks - 1) / shaft_ticks;

    begin_hall();
    for (int32_t k = 0; k < 4; k++) {
        TEST_ASSERT_TRUE(identify_turn_plan_hall(&identify));
        TEST_ASSERT_EQUAL_STRING("hall", identify.aim.kind);
        /* rounded down by less than 8 steps and one of 2^32 */
        TEST_ASSERT_DOUBLE_WITHIN(9.0, 4294967296.0 / turn_ticks, fx_abs(word(PROBE_SPEED)));
        TEST_ASSERT_EQUAL(k < 2, word(PROBE_SPEED) < 0);
        TEST_ASSERT_EQUAL_INT32(turns * shaft_ticks, identify.aim.ticks);
        TEST_ASSERT_EQUAL_INT32(identify_turn_current(&identify), word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_INT32(0, word(PROBE_TRACKING));
        TEST_ASSERT_EQUAL_INT32(2 * 683565276 / 100, word(PROBE_DAMPING));
        TEST_ASSERT_FALSE(identify.aim.rushes);
    }
    TEST_ASSERT_FALSE(identify_turn_plan_hall(&identify));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
}

TEST(test_a_loaded_rotor_has_the_continuous_current_for_the_hall_sensors)
{
    begin_hall();
    identify.turn.loaded = true;
    TEST_ASSERT_TRUE(identify_turn_plan_hall(&identify));
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
}

TEST(test_a_very_slow_vector_has_a_window_that_the_survey_holds)
{
    begin_hall();
    identify.turn.top = 1;
    TEST_ASSERT_TRUE(identify_turn_plan_hall(&identify));
    TEST_ASSERT_EQUAL_INT32(HALL_SURVEY_TICKS_MAX, identify.aim.ticks);
    TEST_ASSERT_INT32_WITHIN(9, 65536, -word(PROBE_SPEED));
}

TEST(test_a_failure_with_the_hall_sensors_ends_the_identification_well)
{
    begin_hall();
    TEST_ASSERT_TRUE(identify_turn_plan_hall(&identify));
    identify_aim_refusal(&identify, "a fault");
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
}
