/* SPDX-License-Identifier: MIT */
/*
 * Derating: each curve at its ends and in the middle, heat beside its equation, the faults beyond.
 */
#include "derating.h"
#include "example_cfg.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>

#define PERIOD_S (0.004)
#define TIME_CONSTANT_S (20.0)
#define MAX (8192)
#define CONTINUOUS (5504)
#define BUS_CALM (22572) /* 310 V */
#define COLD (409U)      /* 20 °C */
#define WARN (1639U)     /* 80 °C, first whole count above */
#define HOT (2048U)      /* 100 °C */
#define FORWARD (10000000)
#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static derating_cfg_t cfg;
static derating_t derating;
static fault_t fault;

void setUp(void)
{
    cfg = example_derating_cfg();
    derating_reset(&derating, &cfg);
    fault = (fault_t){.id = FAULT_NONE};
}

static fault_id_t step_with(int32_t current, uint16_t adc_temperature)
{
    return derating_step(&derating, &cfg, (dq_t){0, current}, adc_temperature, &fault);
}

static torque_range_t range_at(int32_t bus, step_t speed)
{
    const derating_motion_t motion = {.bus = bus, .speed = speed};

    return derating_range(&derating, &cfg, &motion);
}

static void assert_range(int32_t lower, int32_t upper, torque_range_t range)
{
    TEST_ASSERT_EQUAL_INT32(lower, range.lower);
    TEST_ASSERT_EQUAL_INT32(upper, range.upper);
}

static void assert_fault(fault_id_t id, int32_t value, int32_t limit)
{
    TEST_ASSERT_EQUAL_INT(id, fault.id);
    TEST_ASSERT_EQUAL_INT32(value, fault.value);
    TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
}

static void assert_heat(double tolerance, double expected)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected, derating.heat_q24 / 16777216.0);
}

TEST(test_share_is_whole_at_one_end_nothing_at_the_other_and_linear_between)
{
    /* A gain of 2^15·2^5/1024: 1 at 4000 − 1024. */
    const fade_t falling = {.zero = 4000, .gain = 1024, .shift = 5U};
    const fade_t rising = {.zero = 4000, .gain = -1024, .shift = 5U};

    for (int32_t x = 0; x <= 1024; x += 64) {
        const int32_t expected = (x == 1024) ? FX_Q15_MAX : (x * 32);

        TEST_ASSERT_EQUAL_INT32(expected, derating_share(&falling, 4000 - x));
        TEST_ASSERT_EQUAL_INT32(expected, derating_share(&rising, 4000 + x));
    }
    TEST_ASSERT_EQUAL_INT32(0, derating_share(&falling, 65535));
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, derating_share(&falling, 0));
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, derating_share(&rising, 65535));
    TEST_ASSERT_EQUAL_INT32(0, derating_share(&rising, 0));
}

TEST(test_a_fade_without_gain_leaves_everything_at_any_x)
{
    const fade_t none = {.zero = 0, .gain = 0, .shift = 0U};

    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, derating_share(&none, 0));
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, derating_share(&none, 65535));
}

/* ---- heat ---- */

/* Heat after a time from cold: (i/i_c)²·(1 − e^(−t/τ)). */
TEST(test_heat_follows_the_squared_current_with_the_time_constant)
{
    /*
     * Euler's method with T/τ = 2·10^-4: below 10^-4 of the end. The gain has 13 bits: 1.1·10^-4. A
     * step rounds down 2 units of 2^24, which the low-pass contracts to 2·5000 units: 6·10^-4.
     */
    const double tolerance = 1e-4 + 1.1e-4 + 6e-4;
    const double ratio = (double)MAX / CONTINUOUS;
    const double end = ratio * ratio;

    for (int32_t k = 1; k <= 2000; k++) { /* 8 s: heat 0.73 */
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(MAX, COLD));
        assert_heat(end * tolerance, end * (1.0 - exp(-k * PERIOD_S / TIME_CONSTANT_S)));
    }
    TEST_ASSERT_EQUAL_INT32(MAX, derating.thermal);
}

TEST(test_both_axes_heat)
{
    (void)derating_step(&derating, &cfg, (dq_t){-4000, 0}, COLD, &fault);
    TEST_ASSERT_TRUE(derating.heat_q24 > 0);
    derating_reset(&derating, &cfg);
    (void)derating_step(&derating, &cfg, (dq_t){0, -4000}, COLD, &fault);
    TEST_ASSERT_TRUE(derating.heat_q24 > 0);
}

static void set_heat(double heat)
{
    derating.heat_q24 = (int32_t)(heat * 16777216.0);
    cfg.heat_rate = 0;
}

TEST(test_heat_takes_the_limit_from_the_largest_to_the_continuous_current)
{
    static const struct {
        double heat;
        int32_t limit;
    } points[] = {{0.0, MAX},
                  {0.899, MAX},
                  {0.95, (MAX + CONTINUOUS) / 2},
                  {1.0, CONTINUOUS},
                  {1.19, CONTINUOUS}};

    for (uint32_t k = 0U; k < COUNT(points); k++) {
        set_heat(points[k].heat);
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(0, COLD));
        /* One unit of heat in Q14 is 1.6 of the current. */
        TEST_ASSERT_INT32_WITHIN(2, points[k].limit, derating.thermal);
    }
}

/* A drive that takes all it is given ends at the continuous current, never at the fault. */
TEST(test_a_drive_at_its_limit_ends_at_the_continuous_current_without_a_fault)
{
    for (int32_t k = 0; k < 50000; k++) { /* 200 s */
        const torque_range_t range = range_at(BUS_CALM, FORWARD);

        TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(range.upper, COLD));
    }
    /* 0.1 %: heat stands still where a step rounds to nothing, within 6·10^-4 of it. */
    TEST_ASSERT_INT32_WITHIN(6, CONTINUOUS, range_at(BUS_CALM, FORWARD).upper);
    TEST_ASSERT_EQUAL_HEX32(DERATING_HEAT, derating.flags);
}

static void assert_overload(bool overloads, int32_t heat_q14, int32_t current)
{
    derating.heat_q24 = heat_q14 << 10;
    cfg.heat_rate = 0;
    TEST_ASSERT_EQUAL_INT(overloads ? FAULT_OVERLOAD : FAULT_NONE, step_with(current, COLD));
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, derating.thermal);
    if (overloads) {
        assert_fault(FAULT_OVERLOAD, heat_q14, 19661);
    }
}

/*
 * A heat above its limit is there behind another configuration, or a fault that was cleared. The
 * square of 1.09 is below 1.2, that of 1.1 above.
 */
TEST(test_overload_is_a_fault_above_its_heat_where_what_flows_does_not_let_it_cool)
{
    assert_overload(false, 19661, 2 * CONTINUOUS);
    assert_overload(true, 19662, 2 * CONTINUOUS);
    assert_overload(false, 30000, 0);
    assert_overload(false, 30000, (CONTINUOUS * 109) / 100);
    assert_overload(true, 30000, (CONTINUOUS * 110) / 100);
    assert_overload(true, 30000, FX_Q15_MAX); /* beyond the scale */
}

/* Twice the continuous current makes four times its heat: 1.2 after τ·ln(4/2.8). */
TEST(test_an_imposed_current_of_twice_the_continuous_one_is_a_fault_in_time)
{
    const double expected = TIME_CONSTANT_S * log(4.0 / 2.8) / PERIOD_S;
    int32_t k = 0;

    while (step_with(2 * CONTINUOUS, COLD) == FAULT_NONE) {
        k++;
        TEST_ASSERT_TRUE(k < 3000);
    }
    TEST_ASSERT_DOUBLE_WITHIN(expected * 2e-3, expected, k);
}

/* Up to six times the continuous current, the ends of the word: 36 of 64. */
TEST(test_heat_follows_the_square_of_a_current_that_is_far_above_the_continuous_one)
{
    const double tolerance =
        1e-4 + 1.1e-4 +
        6e-4; /* as above; a coarser scale rounds to less than that of a heat of 16 */

    cfg.heat_shift += 4U; /* the same heat at a quarter of the current */
    for (int32_t current = CONTINUOUS / 2; current <= ((CONTINUOUS * 6) / 4); current += 64) {
        const double ratio = 4.0 * current / CONTINUOUS;
        const double end = ratio * ratio;

        derating_reset(&derating, &cfg);
        for (int32_t k = 0; k < 500; k++) {
            (void)step_with(current, COLD);
        }
        assert_heat(end * tolerance, end * (1.0 - exp(-500 * PERIOD_S / TIME_CONSTANT_S)));
    }
}

/*
 * Also where a fast winding's step is larger than the heat's scale, and where the square has no
 * room in that scale: from 4.2 times the continuous current on.
 */
TEST(test_heat_falls_to_that_of_a_current_that_is_far_above_the_continuous_one)
{
    static const struct {
        int32_t tenths; /* of a quarter of the continuous current */
        double begin;
    } falls[] = {{6, 16.0}, {11, 60.0}};
    const double rate = 209.0 / 1048576.0; /* of a period: 209 / 2^16 / 2^4 */

    cfg.heat_shift += 4U; /* the same heat at a quarter of the current */
    cfg.heat_rate = 209;
    cfg.heat_rate_shift = 4U;
    for (uint32_t n = 0U; n < COUNT(falls); n++) {
        const double ratio = 4.0 * falls[n].tenths / 10.0;
        const double end = ratio * ratio;
        /*
         * The gain has 13 bits: 1.1·10^-4. A step rounds down 4 units of 2^24, which the low-pass
         * contracts to 4/rate. The coarser scale has 64 units.
         */
        const double tolerance = (end * 1.1e-4) + (((4.0 / rate) + 64.0) / 16777216.0);

        derating.heat_q24 = (int32_t)(falls[n].begin * 16777216.0);
        for (int32_t k = 1; k <= 5000; k++) {
            (void)step_with((CONTINUOUS * falls[n].tenths) / 10, COLD);
            assert_heat(tolerance, end + ((falls[n].begin - end) * pow(1.0 - rate, k)));
        }
    }
}

TEST(test_heat_stays_in_its_word_at_the_largest_current_for_every_setting)
{
    for (uint32_t shift = 0U; shift <= 27U; shift++) {
        cfg.heat_shift = shift;
        cfg.heat_gain = 32767;
        cfg.heat_rate = 32767;
        cfg.heat_rate_shift = 0U;
        derating_reset(&derating, &cfg);
        for (int32_t k = 0; k < 100; k++) {
            (void)derating_step(&derating, &cfg, (dq_t){18918, 18918}, COLD, &fault);
            TEST_ASSERT_TRUE((derating.heat_q24 >= 0) && (derating.heat_q24 <= 0x40000000));
        }
    }
}

/* ---- temperature ---- */

TEST(test_temperature_takes_the_limit_linearly_to_nothing)
{
    for (uint32_t raw = WARN - 10U; raw <= HOT; raw++) {
        const int32_t above = ((int32_t)raw * 10) - 16384; /* tenths of a count beyond 80 °C */
        const int32_t expected = (above <= 0) ? MAX : (MAX * (4096 - above) / 4096);

        (void)step_with(0, (uint16_t)raw);
        TEST_ASSERT_INT32_WITHIN(2, expected, derating.thermal);
        (void)range_at(BUS_CALM, 0);
        TEST_ASSERT_EQUAL_HEX32((above <= 0) ? 0U : DERATING_TEMPERATURE, derating.flags);
    }
}

static void assert_broken(uint16_t count, int32_t limit)
{
    derating_reset(&derating, &cfg);
    fault = (fault_t){.id = FAULT_NONE};
    for (uint32_t k = 0U; k <= cfg.temperature_periods; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, fault.id);
        (void)step_with(0, count);
        TEST_ASSERT_EQUAL_INT32(0, derating.thermal);
        TEST_ASSERT_EQUAL_HEX32(DERATING_TEMPERATURE, derating.flags_slow);
    }
    assert_fault(FAULT_TEMPERATURE_SENSOR, count, limit);
}

TEST(test_a_count_that_the_sensor_cannot_have_leaves_no_current_and_is_a_fault_of_the_sensor)
{
    cfg.temperature_lowest = 60;
    cfg.temperature_highest = 3970;
    assert_broken(59U, 60);
    assert_broken(0U, 60);
    assert_broken(3971U, 3970);
    derating_reset(&derating, &cfg);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(0, 60U));
    TEST_ASSERT_EQUAL_INT32(MAX, derating.thermal);
    for (uint32_t k = 0U; k <= cfg.temperature_periods; k++) {
        (void)step_with(0, 3970U);
    }
    assert_fault(FAULT_OVERTEMPERATURE, 3970, 2048);
}

TEST(test_overtemperature_takes_more_than_its_periods_in_a_row)
{
    for (uint32_t k = 0U; k < cfg.temperature_periods; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(0, HOT));
    }
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(0, HOT - 1U));
    for (uint32_t k = 0U; k < cfg.temperature_periods; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, step_with(0, HOT));
    }
    TEST_ASSERT_EQUAL_INT(FAULT_OVERTEMPERATURE, step_with(0, HOT + 5U));
    assert_fault(FAULT_OVERTEMPERATURE, (int32_t)HOT + 5, (int32_t)HOT);
}

TEST(test_a_sensor_that_falls_with_the_temperature_works_the_same)
{
    cfg.temperature.gain = -cfg.temperature.gain;
    (void)step_with(0, HOT + 410U);
    TEST_ASSERT_EQUAL_INT32(MAX, derating.thermal);
    (void)step_with(0, HOT);
    TEST_ASSERT_EQUAL_INT32(0, derating.thermal);
}

/* ---- bus ---- */

/* In both directions, exactly where it takes nothing. */
static void check_fade(int32_t bus, int32_t motoring, int32_t braking, uint32_t flags)
{
    const torque_range_t forward = range_at(bus, FORWARD);

    TEST_ASSERT_INT32_WITHIN((motoring == MAX) ? 0 : 3, motoring, forward.upper);
    TEST_ASSERT_INT32_WITHIN((braking == MAX) ? 0 : 3, -braking, forward.lower);
    assert_range(-forward.upper, -forward.lower, range_at(bus, -FORWARD));
    TEST_ASSERT_EQUAL_HEX32(flags, derating.flags);
}

TEST(test_braking_fades_to_nothing_at_the_highest_bus_and_motoring_does_not)
{
    check_fade(25850, MAX, MAX, 0U); /* 355 V */
    check_fade(27488, MAX, MAX / 2, DERATING_BUS_HIGH);
    check_fade(29127, MAX, 0, DERATING_BUS_HIGH); /* 400 V */
    check_fade(32767, MAX, 0, DERATING_BUS_HIGH);
}

TEST(test_motoring_fades_to_nothing_at_the_lowest_bus_and_braking_does_not)
{
    check_fade(16567, MAX, MAX, 0U); /* 227.5 V */
    check_fade(15565, MAX / 2, MAX, DERATING_BUS_LOW);
    check_fade(14564, 0, MAX, DERATING_BUS_LOW); /* 200 V */
    check_fade(0, 0, MAX, DERATING_BUS_LOW);
}

TEST(test_below_the_regeneration_speed_both_directions_count_as_motoring)
{
    const step_t slow = cfg.regeneration_speed;

    assert_range(-MAX, MAX, range_at(29127, slow));
    assert_range(-MAX, MAX, range_at(29127, -slow));
    assert_range(0, MAX, range_at(29127, slow + 1));
    assert_range(-MAX, 0, range_at(29127, -slow - 1));
}

/* ---- bus current ---- */

#define GIVEN (600) /* Q15 of 1.5·60 A: 1.1 A */
#define TAKEN (300)
#define ENOUGH (64) /* slow periods: (3/4)^64 of a voltage is 10^-8 */

/* The range where the voltage has been this one for long. */
static torque_range_t range_with(dq_t voltage, int32_t current_d)
{
    const derating_motion_t motion = {
        .bus = BUS_CALM, .speed = FORWARD, .voltage = voltage, .current_d = current_d};
    torque_range_t range = {0, 0};

    for (int32_t k = 0; k < ENOUGH; k++) {
        range = derating_range(&derating, &cfg, &motion);
    }
    return range;
}

static void limit_bus_current(int32_t given, int32_t taken)
{
    cfg.bus_current_max = given;
    cfg.bus_regeneration_max = taken;
}

/*
 * (limit·bus − v_d·i_d)/|v_q|: with the voltage power is taken, against it fed back, whatever the
 * speed.
 */
TEST(test_bus_current_limits_what_is_taken_and_what_is_fed_back_by_the_power)
{
    static const struct {
        dq_t voltage;
        int32_t current_d;
    } points[] = {{{0, 4000}, 0},        {{0, -4000}, 0},        {{0, 12000}, 0},
                  {{-3000, 9000}, 1000}, {{3000, -9000}, 1000},  {{3000, 9000}, -1000},
                  {{0, 32767}, 16384},   {{-1000, -18918}, 2000}};

    limit_bus_current(GIVEN, TAKEN);
    for (uint32_t k = 0U; k < COUNT(points); k++) {
        const dq_t v = points[k].voltage;
        const torque_range_t range = range_with(v, points[k].current_d);
        const int32_t with = (v.q > 0) ? range.upper : -range.lower;
        const int32_t against = (v.q > 0) ? -range.lower : range.upper;
        const double power_d = (double)v.d * points[k].current_d;
        const double given = (((double)GIVEN * BUS_CALM) - power_d) / abs(v.q);
        const double taken = (((double)TAKEN * BUS_CALM) + power_d) / abs(v.q);
        /*
         * The low-pass stands still within 3 LSB of the voltage, of each axis; a quotient rounds by
         * one.
         */
        const double off = 1.0 + (3.0 * (given + taken + abs(points[k].current_d)) / abs(v.q));

        TEST_ASSERT_DOUBLE_WITHIN(off, given, with);
        TEST_ASSERT_DOUBLE_WITHIN(off, taken, against);
        TEST_ASSERT_EQUAL_HEX32(DERATING_BUS_CURRENT, derating.flags);
        derating_reset(&derating, &cfg);
    }
}

static void assert_limited(int32_t lower, int32_t upper, dq_t voltage, int32_t current_d)
{
    const bool whole = (lower == -MAX) && (upper == MAX);

    derating_reset(&derating, &cfg);
    assert_range(lower, upper, range_with(voltage, current_d));
    TEST_ASSERT_EQUAL_HEX32(whole ? 0U : DERATING_BUS_CURRENT, derating.flags);
}

TEST(test_each_bus_current_limit_acts_in_its_direction_only)
{
    limit_bus_current(GIVEN, 0);
    assert_limited(-MAX, (GIVEN * BUS_CALM) / 9997, (dq_t){0, 10000}, 0);
    limit_bus_current(0, TAKEN);
    assert_limited(-(TAKEN * BUS_CALM) / 9997, MAX, (dq_t){0, 10000}, 0);
}

TEST(test_without_a_bus_current_limit_no_voltage_changes_the_range)
{
    for (int32_t v = -32767; v <= 32767; v += 4681) {
        assert_limited(-MAX, MAX, (dq_t){v, 32767}, 16384);
        assert_limited(-MAX, MAX, (dq_t){v, -32767}, -16384);
    }
}

/*
 * At standstill i_q takes no power, even if i_d takes more than there is. Where i_d takes more than
 * the bus may give, or feeds back more than it may take, nothing is left, and no more than that.
 */
TEST(test_what_the_current_along_d_takes_is_missing_for_torque_that_takes_power)
{
    limit_bus_current(1, 1);
    assert_limited(-MAX, MAX, (dq_t){0, 0}, 0);
    assert_limited(-MAX, MAX, (dq_t){20000, 0}, 16384);
    limit_bus_current(GIVEN, TAKEN);
    assert_limited(-MAX, 0, (dq_t){20000, 100}, 16384);
    assert_limited(0, MAX, (dq_t){20000, 100}, -16384);
    limit_bus_current(32767, 32767); /* beyond all that flows */
    assert_limited(-MAX, MAX, (dq_t){18918, 18918}, 16384);
}

/*
 * A step of the voltage goes by a quarter of what is missing each slow period; a reset forgets it.
 */
TEST(test_the_voltage_of_the_bus_current_is_a_mean_of_some_slow_periods)
{
    const derating_motion_t motion = {.bus = BUS_CALM, .voltage = {.d = -8192, .q = 16384}};
    double left = 1.0;

    for (int32_t k = 0; k < 16; k++) {
        (void)derating_range(&derating, &cfg, &motion);
        left *= 0.75;
        /* Each period rounds by less than one, four in all. */
        TEST_ASSERT_DOUBLE_WITHIN(4.0, 16384.0 * (1.0 - left), derating.voltage.q);
        TEST_ASSERT_DOUBLE_WITHIN(4.0, -8192.0 * (1.0 - left), derating.voltage.d);
    }
    derating_reset(&derating, &cfg);
    TEST_ASSERT_EQUAL_INT32(0, derating.voltage.d);
    TEST_ASSERT_EQUAL_INT32(0, derating.voltage.q);
}

TEST(test_the_smallest_of_all_limits_holds)
{
    set_heat(1.0);
    (void)step_with(0, COLD);
    assert_range(-CONTINUOUS, CONTINUOUS, range_at(BUS_CALM, FORWARD));
    assert_range(0, CONTINUOUS, range_at(29127, FORWARD));
    TEST_ASSERT_EQUAL_HEX32(DERATING_HEAT | DERATING_BUS_HIGH, derating.flags);
    limit_bus_current(GIVEN, 0);
    assert_range(-CONTINUOUS, (GIVEN * BUS_CALM) / 9997, range_with((dq_t){0, 10000}, 0));
    assert_range(-CONTINUOUS, CONTINUOUS, range_with((dq_t){0, 1000}, 0));
    (void)step_with(0, HOT);
    assert_range(0, 0, range_at(BUS_CALM, FORWARD));
}

/* ---- another configuration ---- */

static int32_t changed(int32_t heat_q24, const derating_cfg_t *from, const derating_cfg_t *to)
{
    derating.heat_q24 = heat_q24;
    derating_change(&derating, from, to);
    return derating.heat_q24;
}

/*
 * Half of the square in 2^1 of the scale. The gain is rounded, half of one in 15 bits, and so is
 * the ratio of two gains, down to one in 15 bits: 2^-14 for each change.
 */
TEST(test_the_heat_of_a_current_is_that_of_the_same_current_in_another_scale)
{
    const int32_t heat = 8000000;
    derating_cfg_t other = cfg;
    int32_t there;

    other.heat_gain = (int32_t)lround(cfg.heat_gain * 0.5 / 0.64);
    other.heat_shift = cfg.heat_shift + 1U;
    there = changed(heat, &cfg, &other);
    TEST_ASSERT_INT32_WITHIN(heat / 16384, (int32_t)lround(heat / 0.64), there);
    TEST_ASSERT_INT32_WITHIN(2 * (heat / 16384), heat, changed(there, &other, &cfg));
    for (int32_t any = 0; any < 100000; any += 997) { /* the same scale changes no bit */
        TEST_ASSERT_EQUAL_INT32(any * 10737, changed(any * 10737, &cfg, &cfg));
    }
}

/* A fifth of the continuous current makes 25 times the heat; the ratio of two gains has 14 bits. */
TEST(test_a_configuration_that_bears_less_and_back_leave_the_heat)
{
    const int32_t heat = 19000000; /* 1.13 */
    derating_cfg_t other = cfg;

    other.heat_gain = (cfg.heat_gain * 25) / 16;
    other.heat_shift = cfg.heat_shift + 4U;
    TEST_ASSERT_INT32_WITHIN(2 * (heat / 16384), heat,
                             changed(changed(heat, &cfg, &other), &other, &cfg));
}

TEST(test_the_least_heat_is_exact_in_a_scale_that_is_much_finer)
{
    derating_cfg_t other = cfg;

    cfg.heat_shift = 0U;
    for (uint32_t finer = 0U; finer < 20U; finer++) {
        other.heat_shift = finer;
        TEST_ASSERT_EQUAL_INT32(1L << finer, changed(1, &cfg, &other));
    }
}

TEST(test_a_heat_beyond_its_range_in_another_scale_is_the_most)
{
    derating_cfg_t other = cfg;

    other.heat_gain = 32767;
    other.heat_shift = 27U;
    TEST_ASSERT_EQUAL_INT32(0x40000000, changed(0x40000000, &cfg, &other));
    cfg.heat_gain = 1;
    cfg.heat_shift = 0U;
    TEST_ASSERT_EQUAL_INT32(0x40000000, changed(0x40000000, &cfg, &other));
    TEST_ASSERT_EQUAL_INT32(0, changed(0x40000000, &other, &cfg));
}
