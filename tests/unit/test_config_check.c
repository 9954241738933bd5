/* SPDX-License-Identifier: MIT */
/* Configuration check: every field is named when it is out of its range, on either side. */
#include "config_check.h"
#include "example_cfg.h"
#include "testing.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

/*
 * All fields are 32 bits wide; a shift is unsigned. lowest and highest are accepted in the example
 * configuration with start-up and voltage drive. One beyond them `below` and `above` are named:
 * another field where two must agree.
 */
typedef struct {
    const char *name;
    size_t offset;
    int32_t lowest;
    int32_t highest;
    const char *below;
    const char *above;
} field_t;

/* Of what use a configuration makes of a field. */
typedef enum {
    ALWAYS,
    WITH_STARTUP,
    IN_BOTH,
    WITH_VOLTAGE_DRIVE
} use_t;

typedef struct {
    field_t field;
    use_t use;
} row_t;

#define ROW(path, lo, hi, use) {{#path, offsetof(drive_cfg_t, path), lo, hi, #path, #path}, use},
#define CFG(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, ALWAYS)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, WITH_STARTUP)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    ROW(path, lo_startup, hi, IN_BOTH)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, WITH_VOLTAGE_DRIVE)
static const row_t ROWS[] = {
#include "cfg.def"
};

/* What the rules between two fields leave of a row's range in the example. */
#define RULE(path, below, lo, hi, above) {#path, offsetof(drive_cfg_t, path), lo, hi, below, above}
#define UP_TO(path, lo, hi) RULE(path, #path, lo, hi, #path)

static const field_t RULES[] = {
    /* From derating.current_max to what leaves room for offset_max: 16384 − 1 − 8 − 819. */
    RULE(protection.current_max, "derating.current_max", 8192, 15556, "protection.offset_max"),
    RULE(protection.bus_max, "protection.bus_min", 14564, 32766, "protection.bus_max"),
    UP_TO(protection.bus_min, 0, 29127),   /* bus_max */
    UP_TO(protection.offset_max, 0, 1629), /* 16384 − 1 − 8 − 14746 */
    RULE(derating.current_max, "derating.current_continuous", 5504, 14746,
         "derating.current_max"), /* from current_continuous to protection.current_max */
    UP_TO(derating.current_continuous, 1, 8192), /* current_max */
    /* From speed_loop.speed_max to 32767 in Q15 of Ω_b at speed_shift 11. */
    RULE(observer.speed_limit, "speed_loop.speed_max", 28633115, (32768 * 2048) - 1,
         "observer.speed_limit"),
    RULE(speed_shift, "observer.speed_limit", 11, 16,
         "speed_shift"),                      /* from where the limit fits */
    UP_TO(speed_loop.speed_max, 1, 35791394), /* observer.speed_limit */
    /* From 0, which needs no further field; up to current_move, which is then too small. */
    RULE(startup.current_hold, "startup.current_hold", 0, 8192, "startup.current_move"),
    RULE(startup.align.current_high, "startup.align.current_low", 4064, 16384,
         "startup.align.current_high"),
    UP_TO(startup.align.current_low, 0, 6553),     /* below current_high */
    UP_TO(startup.align.swing_max, 1, 6554),       /* current_high */
    UP_TO(startup.align.sweep_speed, 1, 35791394), /* observer.speed_limit */
    UP_TO(startup.align.sweep_ticks, 1, 3050),     /* pull_ticks */
    RULE(startup.align.pull_ticks, "startup.align.sweep_ticks", 1017, 0x100000,
         "startup.align.pull_ticks"),
    UP_TO(startup.current_move, 6554, 16384), /* from current_hold on */
    UP_TO(startup.track_speed, 1, 2576980),   /* handover_speed */
    RULE(startup.handover_speed, "startup.hold_speed", 1803887, 0x20000000,
         "startup.handover_speed"),
    RULE(startup.hold_speed, "startup.loaded_speed", 1803886, 2576979, /* below handover_speed */
         "startup.hold_speed"),
    UP_TO(startup.loaded_speed, 1, 1803886), /* hold_speed */
    UP_TO(startup.settle_periods, 0, 99),    /* below handover_periods */
    RULE(startup.residual_max, "startup.residual_max", 1, 4915, "startup.residual_lost"),
    UP_TO(startup.residual_lost, 1638, 16384), /* from residual_max on */
    RULE(input.least, "input.least", 0, 1638, "input.low"),
    RULE(input.low, "input.low", 328, 16383, "input.middle"),
    RULE(input.middle, "input.middle", 1638, 31128, "input.high"), /* below high */
    RULE(input.high, "input.high", 16384, 32439, "input.most"),
    UP_TO(input.most, 31129, 32767),
    UP_TO(input.slope_q30, 1, 0x3FFFFFFF), /* no input does nothing for ever */
    UP_TO(input.timeout_ticks, 1, 0x40000000),
    UP_TO(input.arm_ticks, 1, 0x40000000),
};

/* What the example may have there. */
static field_t field_at(size_t row)
{
    for (size_t i = 0; i < COUNT(RULES); i++) {
        if (RULES[i].offset == ROWS[row].field.offset) {
            return RULES[i];
        }
    }
    return ROWS[row].field;
}

static void set(drive_cfg_t *cfg, const field_t *field, int32_t value)
{
    memcpy((char *)cfg + field->offset, &value, sizeof value);
}

static const char *check_with(const field_t *field, int32_t value)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.voltage_drive = example_voltage_drive_cfg();
    cfg.input = example_input_cfg();
    set(&cfg, field, value);
    return config_check(&cfg);
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

TEST(test_every_field_is_accepted_at_both_ends_of_its_range_and_refused_just_outside)
{
    for (size_t i = 0; i < COUNT(ROWS); i++) {
        const field_t field = field_at(i);

        assert_accepted(&field, field.lowest);
        assert_accepted(&field, field.highest);
        assert_refused(&field, field.highest + 1, field.above);
        assert_refused(&field, field.lowest - 1, field.below);
    }
}

/* What the proof takes for any valid configuration. */
TEST(test_every_field_is_refused_just_outside_its_row_and_at_the_ends_of_its_type)
{
    for (size_t i = 0; i < COUNT(ROWS); i++) {
        const field_t *const field = &ROWS[i].field;

        assert_refused(field, field->highest + 1, field->name);
        assert_refused(field, field->lowest - 1, field->name);
        /* As a shift the last two are 2^31 and 2^32 − 1. */
        assert_refused(field, INT32_MAX, field->name);
        assert_refused(field, INT32_MIN, field->name);
        if (field->lowest >= 0) {
            assert_refused(field, -1, field->name);
        }
    }
}

/*
 * Beyond a rule a row has ends too: with all fields there at once, less those that a rule forbids
 * then.
 */
TEST(test_all_fields_are_accepted_at_the_lower_ends_of_their_rows)
{
    drive_cfg_t cfg;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        set(&cfg, &ROWS[i].field, ROWS[i].field.lowest);
    }
    cfg.startup.current_hold = 1;
    cfg.startup.handover_speed = 2; /* above hold_speed */
    cfg.voltage_drive.enabled = 1U;
    TEST_ASSERT_NULL(config_check(&cfg));
}

TEST(test_all_fields_are_accepted_at_the_upper_ends_of_their_rows)
{
    drive_cfg_t cfg;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        set(&cfg, &ROWS[i].field, ROWS[i].field.highest);
    }
    cfg.sampling.sensor_pole_pairs = 0U;
    cfg.sensor.kind = (uint32_t)SENSOR_KIND_NONE;
    cfg.sampling.current_shift = 0U; /* 16384 − 1 − 1 − 16382 leaves no offset */
    cfg.protection.offset_max = 0;
    cfg.input.least--; /* up to the middle, which is below high */
    cfg.input.low--;
    cfg.input.middle--;
    TEST_ASSERT_NULL(config_check(&cfg));
    cfg.observer.speed_limit++; /* elsewhere a rule refuses it too */
    TEST_ASSERT_EQUAL_STRING("observer.speed_limit", config_check(&cfg));
}

/* Without rates there is no observer to hand over to, to start with, or to fail over to. */
TEST(test_with_a_sensor_and_no_observer_what_needs_one_is_named)
{
    drive_cfg_t cfg = example_drive_cfg();
    const struct {
        const char *name;
        int32_t *word;
    } words[] = {{"startup.current_hold", &cfg.startup.current_hold},
                 {"observer.kappa_p", &cfg.observer.kappa_p},
                 {"run.acceleration_q14", &cfg.run.acceleration_q14},
                 {"observer.momentum_q15", &cfg.observer.momentum_q15},
                 {"sensor.observer_above", &cfg.sensor.observer_above}};

    cfg.startup = example_startup_cfg();
    cfg.startup.current_hold = 0;
    cfg.observer.eta = 0;
    cfg.observer.kappa_p = 0;
    cfg.sampling.sensor_pole_pairs = 50U;
    TEST_ASSERT_NULL(config_check(&cfg));
    for (size_t k = 0U; k < COUNT(words); k++) {
        *words[k].word = 1;
        TEST_ASSERT_EQUAL_STRING(words[k].name, config_check(&cfg));
        *words[k].word = 0;
    }
    cfg.sampling.sensor_pole_pairs = 51U;
    TEST_ASSERT_EQUAL_STRING("sampling.sensor_pole_pairs", config_check(&cfg));
}

TEST(test_an_encoder_needs_a_start_up_that_aligns_it)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.sampling.sensor_pole_pairs = 2U;
    for (uint32_t kind = SENSOR_KIND_ENCODER; kind <= (uint32_t)SENSOR_KIND_ENCODER_INDEX; kind++) {
        cfg.sensor.kind = kind;
        cfg.startup.current_hold = 6553;
        TEST_ASSERT_NULL(config_check(&cfg));
        cfg.startup.current_hold = 0;
        TEST_ASSERT_EQUAL_STRING("startup.current_hold", config_check(&cfg));
    }
}

/* Below the hand-over speed the observer cannot hold a motor whose sensor has failed. */
TEST(test_an_observer_beside_a_sensor_needs_a_start_up_for_when_the_sensor_fails)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    for (uint32_t kind = SENSOR_KIND_NONE; kind <= (uint32_t)SENSOR_KIND_ABSOLUTE; kind++) {
        cfg.sampling.sensor_pole_pairs = 2U;
        cfg.sensor.kind = kind;
        cfg.startup.current_hold = 1;
        TEST_ASSERT_NULL(config_check(&cfg));
        cfg.startup.current_hold = 0;
        TEST_ASSERT_EQUAL_STRING("startup.current_hold", config_check(&cfg));
    }
    cfg.sampling.sensor_pole_pairs = 0U;
    TEST_ASSERT_NULL(config_check(&cfg));
}

TEST(test_hall_sectors_that_are_none_are_named)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.sampling.sensor_pole_pairs = 1U;
    cfg.sensor.kind = (uint32_t)SENSOR_KIND_HALL;
    TEST_ASSERT_NULL(config_check(&cfg));
    cfg.sensor.hall.patterns ^= 1U;
    TEST_ASSERT_EQUAL_STRING("sensor.hall.patterns", config_check(&cfg));
    cfg.sensor.hall.patterns ^= 1U;
    cfg.sensor.hall.edges_q16[2] = cfg.sensor.hall.edges_q16[1]; /* no width */
    TEST_ASSERT_EQUAL_STRING("sensor.hall.edges_q16", config_check(&cfg));
    cfg.sensor.hall.edges_q16[2] = cfg.sensor.hall.edges_q16[0] + 1U; /* it turns twice */
    TEST_ASSERT_EQUAL_STRING("sensor.hall.edges_q16", config_check(&cfg));
    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        cfg.sensor.hall.edges_q16[k] = k; /* the last sector is nearly the whole turn */
    }
    TEST_ASSERT_EQUAL_STRING("sensor.hall.edges_q16", config_check(&cfg));
    cfg.sensor.hall.edges_q16[5] = 32769U; /* 5 to 0 is 32767, 4 to 5 is 32765 */
    TEST_ASSERT_NULL(config_check(&cfg));
    cfg.sensor.hall.edges_q16[5] = 32768U; /* half a turn */
    TEST_ASSERT_EQUAL_STRING("sensor.hall.edges_q16", config_check(&cfg));
}

TEST(test_the_sensor_takes_over_below_the_speed_of_the_observer)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.sensor.observer_above = 1000;
    cfg.sensor.sensor_below = 1000;
    TEST_ASSERT_NULL(config_check(&cfg));
    cfg.sensor.sensor_below = 1001;
    TEST_ASSERT_EQUAL_STRING("sensor.sensor_below", config_check(&cfg));
}

/*
 * RUN reads them too, the ramp in torque control; that it does not read the currents is beyond the
 * proof's intervals.
 */
TEST(test_without_a_hold_current_what_run_reads_of_the_startup_is_still_checked)
{
    uint32_t refused = 0U;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        drive_cfg_t cfg = example_drive_cfg();

        if (ROWS[i].use == IN_BOTH) {
            set(&cfg, &ROWS[i].field, 0);
            TEST_ASSERT_NULL_MESSAGE(config_check(&cfg), ROWS[i].field.name);
            set(&cfg, &ROWS[i].field, -1);
            TEST_ASSERT_EQUAL_STRING(ROWS[i].field.name, config_check(&cfg));
            refused++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(6U, refused);
}

static void assert_rows_may_hold_anything(use_t use, const drive_cfg_t *example, size_t count)
{
    static const int32_t values[] = {INT32_MIN, -1, 0, 1, INT32_MAX};
    size_t checked = 0U;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        for (size_t v = 0; (v < COUNT(values)) && (ROWS[i].use == use); v++) {
            drive_cfg_t cfg = *example;

            set(&cfg, &ROWS[i].field, values[v]);
            TEST_ASSERT_NULL_MESSAGE(config_check(&cfg), ROWS[i].field.name);
            checked++;
        }
    }
    TEST_ASSERT_EQUAL_size_t(count * COUNT(values), checked);
}

/* It is not looked at then: RUN starts at once. The hold current itself and the six above are. */
TEST(test_without_a_hold_current_the_rest_of_the_startup_may_hold_anything)
{
    const drive_cfg_t cfg = example_drive_cfg();

    assert_rows_may_hold_anything(WITH_STARTUP, &cfg,
                                  (sizeof(startup_cfg_t) / sizeof(int32_t)) - 7U);
}

TEST(test_without_a_voltage_drive_the_rest_of_it_may_hold_anything)
{
    const drive_cfg_t cfg = example_drive_cfg_with_startup();

    assert_rows_may_hold_anything(WITH_VOLTAGE_DRIVE, &cfg,
                                  (sizeof(voltage_drive_cfg_t) / sizeof(int32_t)) - 1U);
}

TEST(test_the_first_of_several_bad_fields_is_named)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.slow_ticks = 0U;
    TEST_ASSERT_EQUAL_STRING("slow_ticks", config_check(&cfg));
    cfg.modulator.timer_counts = 0;
    TEST_ASSERT_EQUAL_STRING("modulator.timer_counts", config_check(&cfg));
    cfg.speed_loop.pi.ki_shift = 31U;
    TEST_ASSERT_EQUAL_STRING("speed_loop.pi.ki_shift", config_check(&cfg));
    cfg.observer.eta = -1;
    TEST_ASSERT_EQUAL_STRING("observer.eta", config_check(&cfg));
    cfg.sampling.bus_shift = 8U;
    TEST_ASSERT_EQUAL_STRING("sampling.bus_shift", config_check(&cfg));
}

TEST(test_an_empty_configuration_is_refused)
{
    const drive_cfg_t cfg = {.slow_ticks = 0U};

    TEST_ASSERT_EQUAL_STRING("protection.current_max", config_check(&cfg));
}

TEST(test_every_field_has_a_row)
{
    /*
     * Each field of 32 bits but crc stands in cfg.def exactly once, and a rule is of a field of the
     * same name.
     */
    TEST_ASSERT_EQUAL_size_t((sizeof(drive_cfg_t) / sizeof(int32_t)) - 1U, COUNT(ROWS));
    for (size_t i = 0; i < COUNT(ROWS); i++) {
        TEST_ASSERT_EQUAL_STRING(ROWS[i].field.name, field_at(i).name);
        for (size_t j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(ROWS[i].field.offset != ROWS[j].field.offset);
        }
    }
}
