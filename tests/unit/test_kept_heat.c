/* SPDX-License-Identifier: MIT */
/* The heat of the winding over a reset: as it was, in another scale, and where nothing was kept. */
#include "config_guard.h"
#include "example_app.h"
#include "kept_heat.h"
#include "testing.h"

#include <string.h>

#define ONE_Q24 (0x1000000)
#define COPY_WORDS (3U)

static void set_heat(int32_t heat_q24)
{
    app.drive.derating.heat_q24 = heat_q24;
}

/* The words stay, as the supply does. Returns the heat with which the drive starts. */
static int32_t reset_with(const drive_cfg_t *image)
{
    const hal_t kept = hardware;

    memset(&app, 0xA5, sizeof(app));
    hardware = kept;
    cfg = *image;
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &cfg));
    kept_heat_restore(&app);
    return app.drive.derating.heat_q24;
}

void setUp(void)
{
    power_on();
    kept_heat_restore(&app); /* nothing was kept */
}

TEST(test_the_heat_is_after_a_reset_what_it_was_before)
{
    static const int32_t heats[] = {0, 1, ONE_Q24 / 3, ONE_Q24, 0x40000000};

    for (uint32_t k = 0U; k < (sizeof(heats) / sizeof(heats[0])); k++) {
        const drive_cfg_t image = cfg;

        set_heat(heats[k]);
        kept_heat_step(&app);
        TEST_ASSERT_EQUAL_INT32(heats[k], reset_with(&image));
    }
}

TEST(test_the_largest_shift_of_the_heat_comes_back)
{
    drive_cfg_t image = cfg;

    image.derating.heat_shift = 27U;
    (void)reset_with(&image);
    set_heat(ONE_Q24 / 3);
    kept_heat_step(&app);
    TEST_ASSERT_EQUAL_INT32(ONE_Q24 / 3, reset_with(&image));
}

/* A motor that may take twice the current is a quarter as hot by the same square of the current. */
TEST(test_the_heat_is_that_of_the_same_current_where_another_configuration_starts)
{
    drive_cfg_t image = cfg;

    image.derating.heat_gain /= 4;
    set_heat(ONE_Q24);
    kept_heat_step(&app);
    /* The gain's quarter is rounded to one unit of some thousand, the heat to 2^-14. */
    TEST_ASSERT_INT32_WITHIN(ONE_Q24 / 4 / image.derating.heat_gain + (ONE_Q24 >> 14), ONE_Q24 / 4,
                             reset_with(&image));
}

/* Words of zeros and of ones, and words that say what cannot be, in both copies. */
TEST(test_the_winding_counts_as_warm_where_no_valid_words_were_kept)
{
    static const uint32_t words[][COPY_WORDS] = {
        {0U, 0U, 0U},
        {0xFFFFFFFFU, 0xFFFFFFFFU, 0xFFFFFFFFU},
        {0x40000001U, 0x00010001U, ~0x40010002U}, /* hotter than the word goes */
        {0U, 0x00010000U, ~0x00010000U},          /* no gain */
        {0U, 0x00018000U, ~0x00018000U},          /* too large a gain */
        {0U, 0x001C0001U, ~0x001C0001U},          /* too large a shift */
    };
    drive_cfg_t image = cfg;

    for (uint32_t k = 0U; k < (sizeof(words) / sizeof(words[0])); k++) {
        memcpy(hardware.kept, words[k], sizeof(words[k]));
        memcpy(&hardware.kept[COPY_WORDS], words[k], sizeof(words[k]));
        TEST_ASSERT_EQUAL_INT32(KEPT_HEAT_UNKNOWN_Q24, reset_with(&image));
    }
}

/*
 * A reset may come while one copy is written: each bit of it may be wrong, and the other one
 * counts.
 */
TEST(test_a_copy_that_is_broken_is_none_and_the_other_one_counts)
{
    const drive_cfg_t image = cfg;

    set_heat(ONE_Q24 / 8);
    kept_heat_step(&app);
    for (uint32_t bit = 0U; bit < (32U * HAL_KEPT_WORDS); bit++) {
        hardware.kept[bit / 32U] ^= 1U << (bit % 32U);
        TEST_ASSERT_EQUAL_INT32(ONE_Q24 / 8, reset_with(&image));
        hardware.kept[COPY_WORDS + 2U - (bit / 32U)] ^= 1U; /* of the other copy */
        TEST_ASSERT_EQUAL_INT32(KEPT_HEAT_UNKNOWN_Q24, reset_with(&image));
        hardware.kept[COPY_WORDS + 2U - (bit / 32U)] ^= 1U;
        hardware.kept[bit / 32U] ^= 1U << (bit % 32U);
    }
}

/* The heat may be in the new scale already, and the scale that is read beside it the old one. */
TEST(test_nothing_is_kept_while_a_change_waits_to_be_taken)
{
    drive_cfg_t other = cfg;
    hal_t before;

    calibrate();
    set_heat(ONE_Q24);
    kept_heat_step(&app);
    before = hardware;
    other.derating.heat_gain /= 4;
    other.crc = config_guard_crc(&other);
    app_change(&app, &other);
    set_heat(ONE_Q24 / 4);
    kept_heat_step(&app);
    TEST_ASSERT_EQUAL_MEMORY(before.kept, hardware.kept, sizeof(before.kept));
    tick_period();
    TEST_ASSERT_FALSE(app_changes(&app));
    set_heat(ONE_Q24 / 4);
    kept_heat_step(&app);
    TEST_ASSERT_EQUAL_INT32(ONE_Q24 / 4, reset_with(&other));
}

/* A start that fails: before the drive has a configuration, and with one that is refused. */
TEST(test_a_start_that_fails_leaves_the_words_as_they_are)
{
    hal_t before;

    set_heat(ONE_Q24);
    kept_heat_step(&app);
    before = hardware;
    memset(&app, 0, sizeof(app));
    kept_heat_step(&app);
    TEST_ASSERT_EQUAL_MEMORY(&before, &hardware, sizeof(before));
    cfg.crc ^= 1U;
    TEST_ASSERT_NOT_NULL(app_init(&app, &hardware, &cfg));
    kept_heat_step(&app);
    TEST_ASSERT_EQUAL_MEMORY(&before, &hardware, sizeof(before));
}
