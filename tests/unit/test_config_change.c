/* SPDX-License-Identifier: MIT */
/*
 * Change of the configuration: every row of cfg.def, and what stands between two configurations
 * beside them.
 */
#include "config_change.h"
#include "example_cfg.h"
#include "testing.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))
#define RUN (true)
#define REST (false)

typedef struct {
    const char *path;
    size_t offset;
    bool in_run;
} row_t;

#define CFG(path, when, lo, hi, quantity, meaning) {#path, offsetof(drive_cfg_t, path), when},
#define CFG_STARTUP CFG
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) CFG(path, when, , , , )
#define CFG_VOLTAGE CFG
static const row_t ROWS[] = {
#include "cfg.def"
};

static drive_cfg_t from;
static drive_cfg_t to;

void setUp(void)
{
    from = example_drive_cfg_with_startup();
    from.voltage_drive = example_voltage_drive_cfg();
    to = from;
}

/* Every bit of a word counts: the lowest and the highest one change. */
static void differ_in(const row_t *row, uint32_t bits)
{
    uint32_t word;

    to = from;
    memcpy(&word, (char *)&to + row->offset, sizeof word);
    word ^= bits;
    memcpy((char *)&to + row->offset, &word, sizeof word);
}

TEST(test_a_setting_that_may_change_in_run_is_never_refused)
{
    size_t allowed = 0U;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        if (ROWS[i].in_run) {
            differ_in(&ROWS[i], 1U);
            TEST_ASSERT_NULL_MESSAGE(config_change_refused(&from, &to), ROWS[i].path);
            differ_in(&ROWS[i], 0x80000000U);
            TEST_ASSERT_NULL_MESSAGE(config_change_refused(&from, &to), ROWS[i].path);
            allowed++;
        }
    }
    TEST_ASSERT_TRUE(allowed > 0U);
}

TEST(test_a_setting_that_may_change_at_rest_only_is_refused_by_its_path)
{
    size_t refused = 0U;

    for (size_t i = 0; i < COUNT(ROWS); i++) {
        if (!ROWS[i].in_run) {
            differ_in(&ROWS[i], 1U);
            TEST_ASSERT_EQUAL_STRING(ROWS[i].path, config_change_refused(&from, &to));
            differ_in(&ROWS[i], 0x80000000U);
            TEST_ASSERT_EQUAL_STRING(ROWS[i].path, config_change_refused(&from, &to));
            refused++;
        }
    }
    TEST_ASSERT_TRUE(refused > 0U);
}

TEST(test_the_same_configuration_is_not_refused)
{
    TEST_ASSERT_NULL(config_change_refused(&from, &to));
    to.crc++; /* belongs to what differs, and is no setting */
    TEST_ASSERT_NULL(config_change_refused(&from, &to));
}

TEST(test_of_several_the_first_is_named)
{
    to.slow_ticks++;
    TEST_ASSERT_EQUAL_STRING("slow_ticks", config_change_refused(&from, &to));
    to.modulator.timer_counts++;
    TEST_ASSERT_EQUAL_STRING("modulator.timer_counts", config_change_refused(&from, &to));
    to.sampling.current_shift++;
    TEST_ASSERT_EQUAL_STRING("sampling.current_shift", config_change_refused(&from, &to));
}

/*
 * With it the drive is in states that it could not leave, and without it nothing checks the rest of
 * the start-up.
 */
TEST(test_a_startup_neither_comes_nor_goes_while_it_runs)
{
    to.startup.current_hold = 1;
    TEST_ASSERT_NULL(config_change_refused(&from, &to));
    to.startup.current_hold = 0;
    TEST_ASSERT_EQUAL_STRING("startup.current_hold", config_change_refused(&from, &to));
    TEST_ASSERT_EQUAL_STRING("startup.current_hold", config_change_refused(&to, &from));
    to.speed_shift++;
    TEST_ASSERT_EQUAL_STRING("speed_shift", config_change_refused(&from, &to));
    from = to;
    TEST_ASSERT_NULL(config_change_refused(&from, &to));
}
