/* SPDX-License-Identifier: MIT */
/* Configuration check: every field is named when it is out of its range, on either side. */
#include "example_cfg.h"
#include "params.h"
#include "unity.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

/*
 * All fields are 32 bits wide; a shift is unsigned. lowest and highest are accepted in the example
 * configuration with start-up. One beyond them `below` and `above` are named: another field where the two must agree.
 */
typedef struct {
    const char *name;
    size_t offset;
    int32_t lowest;
    int32_t highest;
    const char *below;
    const char *above;
} field_t;

#define WITHIN(path, below, lo, hi, above) \
    {#path, offsetof(drive_cfg_t, path), lo, hi, below, above}
#define FIELD(path, lo, hi) WITHIN(path, #path, lo, hi, #path)
#define PI_PART(path, part, lo, hi) {#path, offsetof(drive_cfg_t, path.part), lo, hi, #path, #path}
#define PI(path) \
    PI_PART(path, kp, 0, 32767), PI_PART(path, ki, 0, 32767), PI_PART(path, kp_shift, 1, 30), \
        PI_PART(path, ki_shift, 1, 30)
#define FADE(path) \
    PI_PART(path, zero, 0, 65535), PI_PART(path, gain, -32767, 32767), PI_PART(path, shift, 0, 16)
/* At observer.speed_limit, 17476 in Q15 of Ω_b: 17476·30469/2^13 = 64999.5, 30470 gives 65001.7. */
#define DECOUPLING(path) WITHIN(path, #path, 0, 30469, "observer.speed_limit")
#define LOOP(path) \
    PI(path.pi_d), PI(path.pi_q), DECOUPLING(path.reactance_d_q13), \
        DECOUPLING(path.reactance_q_q13), DECOUPLING(path.emf_q13), \
        FIELD(path.resistance_q13, 0, 32767)

static const field_t FIELDS[] = {
    FIELD(sampling.current_shift, 0, 7),
    FIELD(sampling.bus_shift, 0, 7),
    FIELD(sampling.offset_log2, 0, 12),
    /* With a sensor no start-up. */
    WITHIN(sampling.sensor_pole_pairs, "sampling.sensor_pole_pairs", 0, 0, "startup.current_hold"),
    /* From derating.current_max to what leaves room for offset_max: 16384 − 1 − 8 − 819. */
    WITHIN(protection.current_max, "derating.current_max", 8192, 15556, "protection.offset_max"),
    WITHIN(protection.bus_max, "protection.bus_min", 14564, 32766, "protection.bus_max"),
    FIELD(protection.bus_min, 0, 29127),   /* up to bus_max */
    FIELD(protection.offset_max, 0, 1629), /* 16384 − 1 − 8 − 14746 */
    WITHIN(derating.current_max, "derating.current_continuous", 5504, 14746,
           "derating.current_max"), /* from current_continuous to protection.current_max */
    FIELD(derating.current_continuous, 1, 8192), /* up to current_max */
    FIELD(derating.heat_shift, 0, 27),
    FIELD(derating.heat_gain, 1, 32767),
    FIELD(derating.heat_rate, 0, 32767),
    FIELD(derating.heat_rate_shift, 0, 30),
    FIELD(derating.heat_max_q14, 1, 1 << 20),
    FADE(derating.heat),
    FADE(derating.temperature),
    FIELD(derating.temperature_periods, 0, 1000000),
    FADE(derating.bus_high),
    FADE(derating.bus_low),
    FIELD(derating.regeneration_speed, 0, 0x20000000),
    FIELD(derating.bus_current_max, 0, 32767),
    FIELD(derating.bus_regeneration_max, 0, 32767),
    FIELD(supervision.phase_range_min, 1, 65535),
    FIELD(supervision.phase_zero_max, 0, 16384),
    FIELD(supervision.phase_speed_max, 1, 0x40000000),
    FIELD(supervision.swing_periods, 0, 1000000),
    FIELD(supervision.voltage_max, 1, 32767),
    FIELD(supervision.follow_error_max, 1, 65535),
    FIELD(supervision.residual_max, 1, 8191),
    FIELD(supervision.mean_shift, 0, 14),
    FIELD(supervision.speed_error_max, 1, 0x40000000),
    FIELD(supervision.speed_error_periods, 0, 1000000),
    FIELD(supervision.runaway_periods, 0, 1000000),
    FIELD(supervision.overspeed, 1, 0x40000000),
    FIELD(supervision.overspeed_periods, 0, 1000000),
    FIELD(supervision.stall_current, 1, 16384),
    FIELD(supervision.stall_speed, 1, 0x20000000),
    FIELD(supervision.stall_periods, 0, 1000000),
    FIELD(supervision.late_max, 0, 1000000),
    FIELD(supervision.late_window, 1, 1000000),
    FIELD(observer.decay, 0, 32767),
    FIELD(observer.volt_gain, 1, 32767),
    FIELD(observer.weight_shift, 2, 15),
    FIELD(observer.flux_q27, 1, 0x7FFFFFF),
    FIELD(observer.iq_gain_q14, 1, 32767),
    FIELD(observer.saliency_q13, 1, 32767),
    FIELD(observer.current_shift, 0, 9),
    FIELD(observer.descent_shift, 4, 12),
    FIELD(observer.rate, 0, 32767),
    FIELD(observer.rate_shift, 0, 30),
    FIELD(observer.proportional, 0, 32767),
    FIELD(observer.proportional_shift, 0, 30),
    FIELD(observer.momentum_q15, 0, 32767),
    /* From speed_loop.speed_max to 32767 in Q15 of Ω_b at speed_shift 11. */
    WITHIN(observer.speed_limit, "speed_loop.speed_max", 28633115, (32768 * 2048) - 1,
           "observer.speed_limit"),
    FIELD(observer.corner, 0, 0x8000000),
    FIELD(observer.rho_max_q13, 0, 32767),
    FIELD(observer.rho_speed_min, 1, 0x20000000),
    WITHIN(speed_shift, "observer.speed_limit", 11, 16,
           "speed_shift"), /* from where the limit fits */
    LOOP(current_loop),
    LOOP(hold_loop),
    PI(speed_loop.pi),
    FIELD(speed_loop.ramp, 1, 0x20000000),
    FIELD(speed_loop.speed_max, 1, 35791394), /* up to observer.speed_limit */
    FIELD(speed_loop.inertia, 0, 32767),
    FIELD(speed_loop.inertia_shift, 0, 30),
    FIELD(speed_loop.inertia_lift, 0, 14),
    FIELD(speed_loop.error_shift, 1, 17),
    FIELD(position_loop.ramp, 1, 0x20000000),
    FIELD(position_loop.speed_max, 1, 0x20000000),
    FIELD(position_loop.braking_inverse, 0x10000, 0x20000),
    FIELD(position_loop.softness_q15, 0, 12288),
    FIELD(position_loop.gain, 0, 32767),
    FIELD(position_loop.gain_shift, 0, 30),
    FIELD(position_loop.distance_shift, 8, 48),
    /* From 0, which needs no further field; up to current_move, which is then too small. */
    WITHIN(startup.current_hold, "startup.current_hold", 0, 8192, "startup.current_move"),
    FIELD(modulator.timer_counts, 1, 32767),
    FIELD(modulator.ratio_max_q15, 1, 18918),
    FIELD(modulator.inverse_max_q12, 4096, 32767),
    FIELD(modulator.dead_time_q15, 0, 8192),
    FIELD(modulator.drop_q15, 0, 2048),
    FIELD(modulator.ripple_q15, 0, 16384),
    FIELD(modulator.edge_slope, 1, 32767),
    FIELD(startup.catch_spin.current, 1, 16384),
    FIELD(startup.catch_spin.wait_ticks, 1, 0x100000),
    FIELD(startup.catch_spin.pulse_ticks, 1, 16),
    FIELD(startup.catch_spin.gap_factor, 1, 16),
    FIELD(startup.catch_spin.pause_max, 1, 256),
    FIELD(startup.catch_spin.emf_current, 1, 32767),
    FIELD(startup.catch_spin.emf_shift, 0, 30),
    FIELD(startup.catch_spin.charge_ticks, 0, 0x100000),
    WITHIN(startup.align.current_high, "startup.align.current_low", 3933, 16384,
           "startup.align.current_high"),
    FIELD(startup.align.current_low, 0, 6553), /* below current_high */
    FIELD(startup.align.slope, 1, 16384),
    FIELD(startup.align.sweep_speed, 1, 35791394), /* up to observer.speed_limit */
    FIELD(startup.align.sweep_ticks, 1, 3050),     /* up to pull_ticks */
    WITHIN(startup.align.pull_ticks, "startup.align.sweep_ticks", 1017, 0x100000,
           "startup.align.pull_ticks"),
    FIELD(startup.align.settle_ticks, 1, 0x100000),
    FIELD(startup.align.measure_log2, 6, 16),
    FIELD(startup.align.step_ticks, 2, 16),
    FIELD(startup.align.step_voltage, 1, 32767),
    FIELD(startup.align.step_fall, 1, 16384),
    FIELD(startup.align.step_drop_q14, 0, 8192),
    FIELD(startup.current_move, 6554, 16384), /* from current_hold on */
    FIELD(run.current_floor, 0, 16384),
    FIELD(run.current_slope, 1, 16384),
    FIELD(startup.current_slope, 1, 16384),
    FIELD(startup.ramp, 1, 0x20000000),
    FIELD(startup.track_speed, 1, 2576980), /* up to handover_speed */
    WITHIN(startup.handover_speed, "startup.hold_speed", 1803887, 0x20000000,
           "startup.handover_speed"),
    FIELD(startup.hold_speed, 1, 2576979), /* below handover_speed */
    WITHIN(startup.residual_max, "startup.residual_max", 1, 4915, "startup.residual_lost"),
    FIELD(startup.residual_lost, 1638, 16384), /* from residual_max on */
    FIELD(startup.lost_periods, 1, 60000),
    FIELD(startup.handover_periods, 1, 60000),
    FIELD(startup.attempts, 1, 100),
    FIELD(model.resistance_limit_q14, 0, 15000),
    FIELD(model.inductance_limit_q14, 0, 8192),
    FIELD(model.flux_limit_q14, 0, 8192),
    FIELD(model.flux_rate, 0, 32767),
    FIELD(model.flux_speed_min, 0, 0x20000000),
    FIELD(slow_ticks, 6, 100),
    FIELD(voltage_drive.enabled, 0, 1),
    PI(voltage_drive.pi),
    FIELD(voltage_drive.speed_min, 0, 0x20000000),
    FIELD(voltage_drive.settle_periods, 1, 10000),
    FIELD(voltage_drive.compensator.gain, 0, 32767),
    FIELD(voltage_drive.compensator.gain_shift, 0, 15),
    FIELD(voltage_drive.compensator.lead_max, 0, 0x40000000),
    FIELD(voltage_drive.compensator.brake_max, 0, 0x40000000),
    FIELD(voltage_drive.compensator.current_min, 1, 32767),
};

void setUp(void)
{
}

void tearDown(void)
{
}

static const char *check_with(const field_t *field, int32_t value)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.voltage_drive = example_voltage_drive_cfg();
    memcpy((char *)&cfg + field->offset, &value, sizeof value);
    return params_check(&cfg);
}

static void assert_refused(const field_t *field, int32_t value, const char *named)
{
    const char *const bad = check_with(field, value);
    char text[128];

    (void)snprintf(text, sizeof text, "%s = %ld is refused", field->name, (long)value);
    TEST_ASSERT_NOT_NULL_MESSAGE(bad, text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(named, bad, text);
}

static void assert_accepted(const field_t *field, int32_t value)
{
    char text[128];

    (void)snprintf(text, sizeof text, "%s = %ld is accepted", field->name, (long)value);
    TEST_ASSERT_NULL_MESSAGE(check_with(field, value), text);
}

static void test_valid_configuration_is_accepted(void)
{
    const drive_cfg_t published = example_drive_cfg();
    const drive_cfg_t with_startup = example_drive_cfg_with_startup();

    TEST_ASSERT_NULL(params_check(&published));
    TEST_ASSERT_NULL(params_check(&with_startup));
}

static void test_every_field_is_accepted_at_both_ends_of_its_range(void)
{
    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        assert_accepted(&FIELDS[i], FIELDS[i].lowest);
        assert_accepted(&FIELDS[i], FIELDS[i].highest);
    }
}

static void test_every_field_is_refused_just_outside_its_range(void)
{
    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        const field_t *const field = &FIELDS[i];

        assert_refused(field, field->highest + 1, field->above);
        assert_refused(field, field->lowest - 1, field->below);
    }
}

static void test_every_field_is_named_at_the_ends_of_its_type(void)
{
    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        /* As a shift the last two are 2^31 and 2^32 − 1. */
        assert_refused(&FIELDS[i], INT32_MAX, FIELDS[i].name);
        assert_refused(&FIELDS[i], INT32_MIN, FIELDS[i].name);
        if (FIELDS[i].lowest >= 0) {
            assert_refused(&FIELDS[i], -1, FIELDS[i].name);
        }
    }
}

/* What the proof takes for any valid configuration: a limit that is wider here would be beyond it. */
static void test_every_field_is_refused_just_outside_what_is_proven(void)
{
#undef FIELD
#define FIELD(path, lo, hi) {#path, offsetof(drive_cfg_t, path), lo, hi, NULL, NULL},
    static const field_t proven[] = {
#include "configuration_common.def"
#include "configuration_startup.def"
#include "configuration_voltage_drive.def"
    };
#undef FIELD

    for (size_t i = 0; i < COUNT(proven); i++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(check_with(&proven[i], proven[i].highest + 1), proven[i].name);
        if (strcmp(proven[i].name, "startup.current_hold") !=
            0) { /* without it there is no start-up */
            TEST_ASSERT_NOT_NULL_MESSAGE(check_with(&proven[i], proven[i].lowest - 1),
                                         proven[i].name);
        }
    }
}

static drive_cfg_t with_sensor(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.observer.rate = 0;
    cfg.observer.proportional = 0;
    return cfg;
}

/* The sensor's speed is the observer's: nothing else may change it. */
static void test_with_a_sensor_a_trained_observer_is_named(void)
{
    drive_cfg_t cfg = with_sensor();

    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.observer.rate = 1;
    TEST_ASSERT_EQUAL_STRING("observer.rate", params_check(&cfg));
    cfg = with_sensor();
    cfg.observer.proportional = 1;
    TEST_ASSERT_EQUAL_STRING("observer.proportional", params_check(&cfg));
    cfg = with_sensor();
    cfg.observer.momentum_q15 = 1;
    TEST_ASSERT_EQUAL_STRING("observer.momentum_q15", params_check(&cfg));
    cfg = with_sensor();
    cfg.sampling.sensor_pole_pairs = 50U;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.sampling.sensor_pole_pairs = 51U;
    TEST_ASSERT_EQUAL_STRING("sampling.sensor_pole_pairs", params_check(&cfg));
}

/* speed·gain/2^13 of each gain of both loops' decoupling, the others zero. */
static const char *check_reach_of(int32_t speed, int32_t gain, size_t which)
{
    drive_cfg_t cfg = example_drive_cfg();
    int32_t *const gains[] = {
        &cfg.current_loop.reactance_d_q13, &cfg.current_loop.reactance_q_q13,
        &cfg.current_loop.emf_q13,         &cfg.hold_loop.reactance_d_q13,
        &cfg.hold_loop.reactance_q_q13,    &cfg.hold_loop.emf_q13,
    };

    for (size_t i = 0; i < COUNT(gains); i++) {
        *gains[i] = (i == which) ? gain : 0;
    }
    cfg.observer.speed_limit = speed * 2048;
    cfg.speed_loop.speed_max = 1;
    return params_check(&cfg);
}

static void test_reach_of_each_decoupling_gain_at_top_speed_is_at_most_65000(void)
{
    for (size_t i = 0; i < 6; i++) {
        /* 65000 exactly, then 65001.97. */
        TEST_ASSERT_NULL(check_reach_of(16384, 32500, i));
        TEST_ASSERT_EQUAL_STRING("observer.speed_limit", check_reach_of(16385, 32499, i));
        /* Each gain may be as large as its format at a top speed for it: 64998.02, then 65002.02. */
        TEST_ASSERT_NULL(check_reach_of(16250, 32767, i));
        TEST_ASSERT_EQUAL_STRING("observer.speed_limit", check_reach_of(16251, 32767, i));
        TEST_ASSERT_EQUAL_STRING("observer.speed_limit", check_reach_of(32767, 32767, i));
        TEST_ASSERT_NULL(check_reach_of(32767, 16250, i));
        TEST_ASSERT_NOT_NULL(check_reach_of(1, 32768, i));
    }
}

/* RUN itself reads the first two; that it does not read the currents is beyond the proof's intervals. */
static bool is_of_run(const field_t *field)
{
    static const char *const names[] = {"startup.current_hold", "startup.handover_speed",
                                        "startup.current_move", "startup.current_slope"};
    bool found = false;

    for (size_t i = 0; i < COUNT(names); i++) {
        found = found || (strcmp(field->name, names[i]) == 0);
    }
    return found;
}

static bool is_of_startup(const field_t *field)
{
    return (strncmp(field->name, "startup.", 8) == 0) && !is_of_run(field);
}

static void test_without_a_hold_current_what_run_reads_of_the_startup_is_still_checked(void)
{
    uint32_t refused = 0U;

    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        drive_cfg_t cfg = example_drive_cfg();
        const int32_t below = -1;

        if (is_of_run(&FIELDS[i])) {
            memcpy((char *)&cfg + FIELDS[i].offset, &below, sizeof below);
            TEST_ASSERT_EQUAL_STRING(FIELDS[i].name, params_check(&cfg));
            refused++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(4U, refused);
}

/* It is not looked at then: RUN starts at once. */
static void test_without_a_hold_current_the_rest_of_the_startup_may_hold_anything(void)
{
    static const int32_t values[] = {INT32_MIN, -1, 0, 1, INT32_MAX};
    uint32_t checked = 0U;

    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        for (size_t v = 0; (v < COUNT(values)) && is_of_startup(&FIELDS[i]); v++) {
            drive_cfg_t cfg = example_drive_cfg();

            memcpy((char *)&cfg + FIELDS[i].offset, &values[v], sizeof values[v]);
            TEST_ASSERT_NULL_MESSAGE(params_check(&cfg), FIELDS[i].name);
            checked++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32((sizeof(startup_cfg_t) / sizeof(int32_t) - 4U) * COUNT(values),
                             checked);
}

static void test_thresholds_of_the_startup_out_of_order_are_named(void)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.startup.hold_speed = cfg.startup.handover_speed;
    TEST_ASSERT_EQUAL_STRING("startup.hold_speed", params_check(&cfg));
    cfg.startup.hold_speed = cfg.startup.handover_speed - 1;
    cfg.startup.track_speed = cfg.startup.handover_speed;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.startup.track_speed++;
    TEST_ASSERT_EQUAL_STRING("startup.track_speed", params_check(&cfg));
    cfg.startup.track_speed = 1;
    cfg.startup.current_move = cfg.startup.current_hold;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.startup.current_move--;
    TEST_ASSERT_EQUAL_STRING("startup.current_move", params_check(&cfg));
}

static void test_the_vector_turns_no_faster_than_the_observer_follows(void)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.speed_loop.speed_max = 1;
    cfg.observer.speed_limit = cfg.startup.align.sweep_speed;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.observer.speed_limit--;
    TEST_ASSERT_EQUAL_STRING("startup.align.sweep_speed", params_check(&cfg));
}

static void test_top_speed_of_the_speed_loop_is_at_most_what_the_observer_follows(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.speed_loop.speed_max = cfg.observer.speed_limit;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.observer.speed_limit--;
    TEST_ASSERT_EQUAL_STRING("speed_loop.speed_max", params_check(&cfg));
    cfg.speed_loop.speed_max--;
    TEST_ASSERT_NULL(params_check(&cfg));
    /* The largest of both. */
    cfg.speed_shift = 16U;
    cfg.observer.speed_limit = 0x20000000;
    cfg.speed_loop.speed_max = 0x20000000;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.speed_loop.speed_max = 0x20000001;
    TEST_ASSERT_EQUAL_STRING("speed_loop.speed_max", params_check(&cfg));
}

static void test_current_demand_is_at_most_what_the_protection_allows(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.derating.current_max = cfg.protection.current_max;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.protection.current_max--;
    TEST_ASSERT_EQUAL_STRING("derating.current_max", params_check(&cfg));
    cfg.protection.offset_max = 0;
    cfg.protection.current_max = 16375; /* 16384 − 1 − 8 */
    cfg.derating.current_max = 16375;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.derating.current_max = 16376;
    TEST_ASSERT_EQUAL_STRING("derating.current_max", params_check(&cfg));
}

static void test_bus_limits_out_of_order_are_named(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.protection.bus_max = cfg.protection.bus_min - 1;
    TEST_ASSERT_EQUAL_STRING("protection.bus_min", params_check(&cfg));
    cfg.protection.bus_max = 0;
    TEST_ASSERT_EQUAL_STRING("protection.bus_max", params_check(&cfg));
    cfg.protection.bus_max = INT32_MIN;
    TEST_ASSERT_EQUAL_STRING("protection.bus_max", params_check(&cfg));
}

static void test_speed_limit_beyond_the_speed_base_is_named(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.speed_shift = 10U;
    TEST_ASSERT_EQUAL_STRING("observer.speed_limit", params_check(&cfg));
    cfg.speed_shift = 0U;
    TEST_ASSERT_EQUAL_STRING("speed_shift", params_check(&cfg));
    /* The widest base takes the largest limit. */
    cfg.speed_shift = 16U;
    cfg.observer.speed_limit = 0x20000000;
    TEST_ASSERT_NULL(params_check(&cfg));
    cfg.observer.speed_limit = 0x20000001;
    TEST_ASSERT_EQUAL_STRING("observer.speed_limit", params_check(&cfg));
}

static void test_the_first_of_several_bad_fields_is_named(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.slow_ticks = 0U;
    TEST_ASSERT_EQUAL_STRING("slow_ticks", params_check(&cfg));
    cfg.modulator.timer_counts = 0;
    TEST_ASSERT_EQUAL_STRING("modulator.timer_counts", params_check(&cfg));
    cfg.speed_loop.pi.ki_shift = 31U;
    TEST_ASSERT_EQUAL_STRING("speed_loop.pi", params_check(&cfg));
    cfg.observer.rate = -1;
    TEST_ASSERT_EQUAL_STRING("observer.rate", params_check(&cfg));
    cfg.sampling.bus_shift = 8U;
    TEST_ASSERT_EQUAL_STRING("sampling.bus_shift", params_check(&cfg));
}

static void test_an_empty_configuration_is_refused(void)
{
    const drive_cfg_t cfg = {.slow_ticks = 0U};

    TEST_ASSERT_EQUAL_STRING("protection.current_max", params_check(&cfg));
}

static void test_the_table_of_this_test_knows_every_field(void)
{
    /* Each field of 32 bits but crc stands in the table exactly once. */
    TEST_ASSERT_EQUAL_size_t((sizeof(drive_cfg_t) / sizeof(int32_t)) - 1U, COUNT(FIELDS));
    for (size_t i = 0; i < COUNT(FIELDS); i++) {
        for (size_t j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(FIELDS[i].offset != FIELDS[j].offset);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_valid_configuration_is_accepted);
    RUN_TEST(test_every_field_is_accepted_at_both_ends_of_its_range);
    RUN_TEST(test_every_field_is_refused_just_outside_its_range);
    RUN_TEST(test_every_field_is_named_at_the_ends_of_its_type);
    RUN_TEST(test_every_field_is_refused_just_outside_what_is_proven);
    RUN_TEST(test_with_a_sensor_a_trained_observer_is_named);
    RUN_TEST(test_reach_of_each_decoupling_gain_at_top_speed_is_at_most_65000);
    RUN_TEST(test_without_a_hold_current_what_run_reads_of_the_startup_is_still_checked);
    RUN_TEST(test_without_a_hold_current_the_rest_of_the_startup_may_hold_anything);
    RUN_TEST(test_thresholds_of_the_startup_out_of_order_are_named);
    RUN_TEST(test_the_vector_turns_no_faster_than_the_observer_follows);
    RUN_TEST(test_top_speed_of_the_speed_loop_is_at_most_what_the_observer_follows);
    RUN_TEST(test_current_demand_is_at_most_what_the_protection_allows);
    RUN_TEST(test_bus_limits_out_of_order_are_named);
    RUN_TEST(test_speed_limit_beyond_the_speed_base_is_named);
    RUN_TEST(test_the_first_of_several_bad_fields_is_named);
    RUN_TEST(test_an_empty_configuration_is_refused);
    RUN_TEST(test_the_table_of_this_test_knows_every_field);
    return UNITY_END();
}
