/* SPDX-License-Identifier: MIT */
/*
 * The block in force and the one that is prepared: what takes its place, when, and what is refused
 * with which words.
 */
#include "commander.h"
#include "config_guard.h"
#include "example_app.h"
#include "flash_model.h"
#include "live_config.h"
#include "seeded.h"
#include "testing.h"

#include <stddef.h>
#include <string.h>

#define RUNNING "cannot change while the drive runs; stop the drive first"
#define LOCKED "protects less than what is in force; stop the drive and unlock first"
#define PENDING "the change before has not been taken yet; ask again"
#define NO_BLOCK "no block was prepared"
#define CEILING \
    "protects less than the files that this image was made from; a new image sets another limit"
#define RANDOM_CHANGES (2000U)
#define RANDOM_CHANGES_OF_MANY (100000U)
#define OTHER_BLOCK "another block was prepared; write it again"

static about_t of_image;
static drive_cfg_t image_cfg;
static live_config_t live;
static config_block_t wanted;

void setUp(void)
{
    flash_new(0U);
    memset(&app, 0, sizeof app);
    power_on();
    image_cfg = cfg;
    of_image = ABOUT;
    of_image.identity = (config_identity_t){.schema = 3U, .board = 4U};
    memset(&live, 0xA5, sizeof live);
    live_config_init(&live, &app, &hardware, &of_image, &image_cfg);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &live.in_force->cfg));
    calibrate();
    wanted = *live.in_force;
}

static void seal(void)
{
    const config_block_t whole = wanted;
    drive_cfg_t settings = wanted.cfg;

    settings.crc = config_guard_crc(&settings);
    config_block_make(&wanted, &whole.identity, &whole.about, &settings);
}

/* The words that differ, and nothing else. */
static void write_wanted(void)
{
    for (uint32_t at = 0U; at < CONFIG_BLOCK_WORDS; at++) {
        const uint32_t word = config_block_word(&wanted, at);

        if (word != config_block_word(live.in_force, at)) {
            TEST_ASSERT_NULL(live_config_write(&live, at, word).why);
        }
    }
}

static void assert_verdict(const char *path, const char *why, live_config_verdict_t verdict)
{
    TEST_ASSERT_EQUAL_STRING(path, verdict.path);
    TEST_ASSERT_EQUAL_STRING(why, verdict.why);
}

static void take(void)
{
    tick_period();
    live_config_step(&live);
}

static live_config_verdict_t apply_wanted(void)
{
    write_wanted();
    return live_config_apply(&live, wanted.cfg.crc);
}

static void bring_into_force(void)
{
    assert_verdict(NULL, NULL, apply_wanted());
    take();
    TEST_ASSERT_EQUAL_MEMORY(&wanted, live.in_force, sizeof wanted);
}

static void stop(void)
{
    commander_stop(&app, SOURCE_LINK);
    tick_period();
}

static void run(void)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    tick_period();
    tick(2U);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
}

/* Of motor and tuning: a gain may change in RUN, the scale of speeds may not. */
static void want_gain(void)
{
    wanted.cfg.observer.kappa_p++;
    seal();
}

static void want_scale(void)
{
    wanted.cfg.speed_shift++;
    seal();
}

TEST(test_a_gain_takes_its_place_in_run_at_a_tick_and_not_before)
{
    const config_block_t before = *live.in_force;

    run();
    want_gain();
    write_wanted();
    TEST_ASSERT_EQUAL_MEMORY(&before, live.in_force, sizeof before);
    assert_verdict(NULL, NULL, live_config_apply(&live, wanted.cfg.crc));
    live_config_step(&live);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&before, live.in_force, sizeof before, "no tick has come");
    TEST_ASSERT_EQUAL_MEMORY(&before.cfg, app.drive.cfg, sizeof before.cfg);
    take();
    TEST_ASSERT_EQUAL_MEMORY(&wanted, live.in_force, sizeof wanted);
    TEST_ASSERT_EQUAL_PTR(&live.in_force->cfg, app.drive.cfg);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
}

TEST(test_changes_follow_each_other_with_the_words_that_differ)
{
    for (uint32_t k = 0U; k < 5U; k++) {
        want_gain();
        bring_into_force();
    }
}

TEST(test_a_setting_that_cannot_change_in_run_is_named_and_changes_at_rest)
{
    run();
    want_scale();
    assert_verdict("speed_shift", RUNNING, apply_wanted());
    take();
    TEST_ASSERT_NOT_EQUAL_UINT32(wanted.cfg.crc, live.in_force->cfg.crc);
    stop();
    bring_into_force();
    TEST_ASSERT_EQUAL_UINT32(wanted.cfg.crc, live.in_force->cfg.crc);
}

/* Its answer may have been lost on the line. */
TEST(test_an_apply_that_is_asked_for_again_has_the_same_verdict_and_no_effect)
{
    assert_verdict(NULL, NO_BLOCK, live_config_apply(&live, live.in_force->cfg.crc));
    run();
    want_scale();
    assert_verdict("speed_shift", RUNNING, apply_wanted());
    stop();
    assert_verdict("speed_shift", RUNNING, live_config_apply(&live, wanted.cfg.crc));
    TEST_ASSERT_FALSE(app_changes(&app));
    bring_into_force();
    assert_verdict(NULL, NULL, live_config_apply(&live, wanted.cfg.crc));
    TEST_ASSERT_FALSE(app_changes(&app));
}

/*
 * Whoever asks for a block that he has not written must not take the verdict about another one for
 * its own.
 */
TEST(test_only_the_crc_of_the_last_apply_has_its_verdict_again)
{
    want_gain();
    bring_into_force();
    assert_verdict(NULL, NO_BLOCK, live_config_apply(&live, wanted.cfg.crc ^ 1U));
    assert_verdict(NULL, NULL, live_config_apply(&live, wanted.cfg.crc));
    live_config_forget(&live);
    assert_verdict(NULL, NO_BLOCK, live_config_apply(&live, wanted.cfg.crc));
}

TEST(test_after_the_configuration_of_the_image_no_verdict_of_before_is_repeated)
{
    want_gain();
    bring_into_force();
    assert_verdict(NULL, NULL, live_config_restore(&live));
    take();
    assert_verdict(NULL, NO_BLOCK, live_config_apply(&live, wanted.cfg.crc));
}

TEST(test_words_that_were_refused_are_not_part_of_what_is_prepared_next)
{
    run();
    want_scale();
    (void)apply_wanted();
    wanted = *live.in_force;
    want_gain();
    bring_into_force();
}

TEST(test_another_crc_than_that_of_the_prepared_block_is_refused)
{
    want_gain();
    write_wanted();
    assert_verdict(NULL, OTHER_BLOCK, live_config_apply(&live, wanted.cfg.crc ^ 1U));
    take();
    TEST_ASSERT_NOT_EQUAL_UINT32(wanted.cfg.crc, live.in_force->cfg.crc);
}

TEST(test_a_preparation_that_is_forgotten_begins_anew_with_the_block_in_force)
{
    (void)live_config_write(&live, 30U, 0xDEADBEEFU);
    live_config_forget(&live);
    want_gain();
    bring_into_force();
}

TEST(test_a_damaged_block_and_a_bad_setting_are_refused)
{
    want_gain();
    write_wanted();
    (void)live_config_write(&live, 40U, 0xDEADBEEFU);
    assert_verdict(NULL, "the block is damaged", live_config_apply(&live, wanted.cfg.crc));
    wanted.cfg.slow_ticks = 5U;
    seal();
    assert_verdict("slow_ticks", "the block has a setting that the drive does not take",
                   apply_wanted());
    wanted = *live.in_force;
    wanted.identity.board++;
    seal();
    assert_verdict(NULL, "the block was made for another board", apply_wanted());
    take();
    TEST_ASSERT_EQUAL_MEMORY(&image_cfg, &live.in_force->cfg, sizeof image_cfg);
}

/* Whatever else would let it pass: in RUN, at rest, of this motor or another one. */
TEST(test_a_limit_that_the_image_has_is_not_lifted)
{
    const config_block_t before = *live.in_force;

    for (uint32_t k = 0U; k < 2U; k++) {
        wanted.cfg.protection.bus_max++;
        seal();
        assert_verdict("protection.bus_max", CEILING, apply_wanted());
        wanted = before;
        wanted.cfg.derating.current_max++;
        seal();
        assert_verdict("derating.current_max", CEILING, apply_wanted());
        take();
        TEST_ASSERT_EQUAL_MEMORY(&before, live.in_force, sizeof before);
        wanted = before;
        run();
    }
}

/* Who has an example motor in the image has not said what his own one bears. */
TEST(test_with_an_example_motor_in_the_image_another_motor_may_have_more_current)
{
    of_image.is_example = 1U;
    wanted.cfg.derating.current_max++;
    seal();
    TEST_ASSERT_NULL(commander_unlock(&app));
    bring_into_force();
    wanted.cfg.protection.current_max++;
    seal();
    assert_verdict("protection.current_max", CEILING, apply_wanted());
}

/* A late tick more than before is a fault. */
static void want_less(void)
{
    wanted.cfg.supervision.late_max++;
    seal();
}

TEST(test_what_protects_is_lessened_once_after_it_was_unlocked)
{
    want_less();
    assert_verdict("supervision.late_max", LOCKED, apply_wanted());
    TEST_ASSERT_NULL(commander_unlock(&app));
    commander_step(&app);
    bring_into_force();
    want_less();
    assert_verdict("supervision.late_max", LOCKED, apply_wanted());
}

TEST(test_a_drive_that_does_not_rest_stays_locked)
{
    run();
    TEST_ASSERT_NOT_NULL(commander_unlock(&app));
    want_less();
    assert_verdict("supervision.late_max", LOCKED, apply_wanted());
    wanted.cfg.supervision.late_max -= 2U;
    seal();
    bring_into_force();
}

TEST(test_a_run_locks_what_was_unlocked)
{
    TEST_ASSERT_NULL(commander_unlock(&app));
    run();
    commander_step(&app);
    stop();
    want_less();
    assert_verdict("supervision.late_max", LOCKED, apply_wanted());
}

TEST(test_what_was_unlocked_for_a_block_that_is_refused_is_locked_again)
{
    TEST_ASSERT_NULL(commander_unlock(&app));
    wanted.cfg.protection.bus_max++;
    seal();
    assert_verdict("protection.bus_max", CEILING, apply_wanted());
    wanted.cfg.protection.bus_max--;
    want_less();
    assert_verdict("supervision.late_max", LOCKED, apply_wanted());
}

/* A motor that runs is not left with less, whoever has chosen it. */
TEST(test_the_configuration_of_the_image_is_locked_too_while_the_drive_runs)
{
    wanted.cfg.supervision.late_max--;
    seal();
    bring_into_force();
    run();
    assert_verdict("supervision.late_max", LOCKED, live_config_restore(&live));
    stop();
    assert_verdict(NULL, NULL, live_config_restore(&live));
}

/*
 * Twice as wide as at the start, and no step further; what was unlocked is where the next steps
 * begin.
 */
TEST(test_many_small_steps_take_no_limit_away)
{
    wanted.cfg.supervision.overspeed *= 2;
    seal();
    bring_into_force();
    wanted.cfg.supervision.overspeed += 2;
    seal();
    assert_verdict("supervision.overspeed", LOCKED, apply_wanted());
    TEST_ASSERT_NULL(commander_unlock(&app));
    bring_into_force();
    wanted.cfg.supervision.overspeed += 2;
    seal();
    bring_into_force();
}

/* The author of the image has chosen it. */
TEST(test_the_configuration_of_the_image_needs_no_unlocking)
{
    wanted.cfg.supervision.late_max--;
    seal();
    bring_into_force();
    assert_verdict(NULL, NULL, live_config_restore(&live));
    take();
    TEST_ASSERT_EQUAL_UINT32(image_cfg.crc, live.in_force->cfg.crc);
}

/* Some words of the limits of board and motor, each within twice of what it was. */
static void want_any(seeded_t *random)
{
    const uint32_t first = offsetof(config_block_t, cfg.protection) / 4U;
    const uint32_t end = (offsetof(config_block_t, cfg.derating) + sizeof(derating_cfg_t)) / 4U;

    wanted = *live.in_force;
    for (int32_t k = seeded_in(random, 1, 4); k > 0; k--) {
        const uint32_t at = (uint32_t)seeded_in(random, (int32_t)first, (int32_t)end - 1);
        const int64_t word = (int32_t)config_block_word(&wanted, at);

        config_block_set_word(&wanted, at, (uint32_t)((word * seeded_in(random, 0, 64)) / 32));
    }
    seal();
}

static void assert_below_ceilings(void)
{
    const derating_cfg_t *const limits = &image_cfg.derating;
    const derating_cfg_t *const found = &live.in_force->cfg.derating;

    TEST_ASSERT_TRUE(live.in_force->cfg.protection.current_max <= image_cfg.protection.current_max);
    TEST_ASSERT_TRUE(live.in_force->cfg.protection.bus_max <= image_cfg.protection.bus_max);
    TEST_ASSERT_TRUE(found->current_max <= limits->current_max);
    TEST_ASSERT_TRUE(found->current_continuous <= limits->current_continuous);
    TEST_ASSERT_TRUE(found->heat_max_q14 <= limits->heat_max_q14);
    TEST_ASSERT_TRUE(found->heat_rate > 0);
}

TEST(test_no_random_configuration_is_in_force_above_the_ceilings)
{
    const unsigned changes = testing_runs(RANDOM_CHANGES, RANDOM_CHANGES_OF_MANY);
    seeded_t random = {.state = 77U};
    uint32_t taken = 0U;

    for (unsigned k = 0U; k < changes; k++) {
        want_any(&random);
        (void)commander_unlock(&app);
        taken += (apply_wanted().why == NULL) ? 1U : 0U;
        take();
        assert_below_ceilings();
        if ((k % 10U) == 9U) {
            (void)live_config_restore(&live);
            take();
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(changes / 50U, taken);
    TEST_ASSERT_LESS_THAN_UINT32(changes, taken);
}

TEST(test_a_word_beyond_the_block_is_refused)
{
    assert_verdict(NULL, NULL, live_config_write(&live, CONFIG_BLOCK_WORDS - 1U, 0U));
    assert_verdict(NULL, "the block has no such word",
                   live_config_write(&live, CONFIG_BLOCK_WORDS, 0U));
}

TEST(test_while_a_change_waits_for_its_tick_nothing_else_is_prepared)
{
    want_gain();
    assert_verdict(NULL, NULL, apply_wanted());
    assert_verdict(NULL, PENDING, live_config_write(&live, 0U, 0U));
    assert_verdict(NULL, PENDING, live_config_apply(&live, wanted.cfg.crc));
    assert_verdict(NULL, PENDING, live_config_restore(&live));
    assert_verdict(NULL, PENDING, live_config_store(&live));
    hardware.health.tick_lost = true;
    assert_verdict(NULL, "the change before waits for the control tick, which does not run",
                   live_config_write(&live, 0U, 0U));
    hardware.health.tick_lost = false;
    take();
    TEST_ASSERT_EQUAL_MEMORY(&wanted, live.in_force, sizeof wanted);
}

TEST(test_without_a_tick_no_change_is_taken_up)
{
    want_gain();
    write_wanted();
    hardware.health.tick_lost = true;
    assert_verdict(NULL, "the control tick does not run", live_config_apply(&live, wanted.cfg.crc));
    hardware.health.tick_lost = false;
    hardware.ticks = 0U;
    assert_verdict(NULL, "the control tick does not run", apply_wanted());
    TEST_ASSERT_FALSE(app_changes(&app));
}

TEST(test_name_and_motor_of_the_block_in_force_are_those_of_about)
{
    wanted.about.pole_pairs = 3U;
    wanted.about.speed_max_rpm = 1000;
    config_block_name(wanted.about.name, "another motor");
    want_gain();
    (void)apply_wanted();
    TEST_ASSERT_EQUAL_STRING("a board", live.about.name);
    take();
    TEST_ASSERT_EQUAL_STRING("another motor", live.about.name);
    TEST_ASSERT_EQUAL_UINT32(3U, live.about.rotation.pole_pairs);
    TEST_ASSERT_EQUAL_INT32(1000, live.about.speed_max_rpm);
}

/* An input that has to be seen at rest would stop the motor that it runs. */
TEST(test_a_change_in_run_upsets_an_input_unless_the_run_is_its_own)
{
    static const source_t sources[] = {SOURCE_CONSOLE, SOURCE_LINK, SOURCE_INPUT};

    for (uint32_t k = 0U; k < (sizeof sources / sizeof sources[0]); k++) {
        setUp();
        TEST_ASSERT_NULL(commander_run(&app, sources[k]));
        tick_period();
        const uint32_t upsets = app.upsets;

        want_gain();
        bring_into_force();
        TEST_ASSERT_EQUAL(sources[k], commander_source(&app));
        TEST_ASSERT_EQUAL_UINT32(upsets + ((sources[k] == SOURCE_INPUT) ? 0U : 1U), app.upsets);
    }
}

/* 1000 rpm of the same motor are half of what was asked for. */
TEST(test_a_speed_in_force_stays_within_the_new_limit)
{
    run();
    (void)commander_set_speed(&app, SOURCE_LINK, -EXAMPLE_SPEED_STEP);
    wanted.about.speed_max_rpm = 1000;
    want_gain();
    bring_into_force();
    TEST_ASSERT_EQUAL_INT32(-14316558, command_mailbox_take(&app.mailbox).target);
    (void)commander_set_speed(&app, SOURCE_LINK, EXAMPLE_SPEED_STEP);
    commander_limit_speed(&app, 14316558);
    TEST_ASSERT_EQUAL_INT32(14316558, command_mailbox_take(&app.mailbox).target);
}

/* The target is in electrical steps of the motor before. */
TEST(test_where_the_drive_begins_anew_no_target_is_left)
{
    const drive_command_t position = {.target = 77, .mode = (uint8_t)DRIVE_MODE_POSITION};

    command_mailbox_post(&app.mailbox, &position);
    want_gain();
    bring_into_force();
    TEST_ASSERT_EQUAL_INT32_MESSAGE(77, command_mailbox_take(&app.mailbox).target, "it goes on");
    want_scale();
    (void)apply_wanted();
    TEST_ASSERT_EQUAL_INT32_MESSAGE(77, command_mailbox_take(&app.mailbox).target, "not taken");
    take();
    TEST_ASSERT_EQUAL_INT32(0, command_mailbox_take(&app.mailbox).target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, command_mailbox_take(&app.mailbox).mode);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

TEST(test_the_configuration_of_the_image_comes_back)
{
    wanted.about.speed_max_rpm = 1000;
    want_scale();
    bring_into_force();
    calibrate(); /* the drive has begun anew */
    run();
    assert_verdict("speed_shift", RUNNING, live_config_restore(&live));
    stop();
    assert_verdict(NULL, NULL, live_config_restore(&live));
    take();
    TEST_ASSERT_EQUAL_MEMORY(&image_cfg, &live.in_force->cfg, sizeof image_cfg);
    TEST_ASSERT_EQUAL_INT32(2000, live.about.speed_max_rpm);
    TEST_ASSERT_EQUAL_STRING("a board", live.about.name);
    assert_verdict(NULL, NULL, live_config_restore(&live));
    TEST_ASSERT_FALSE_MESSAGE(app_changes(&app), "it is in force already");
}

TEST(test_the_block_in_force_is_stored_at_rest_and_the_next_start_takes_it)
{
    want_gain();
    bring_into_force();
    run();
    assert_verdict(NULL, "the drive does not rest with open gates; stop it first",
                   live_config_store(&live));
    stop();
    assert_verdict(NULL, NULL, live_config_store(&live));
    live_config_init(&live, &app, &hardware, &of_image, &image_cfg);
    TEST_ASSERT_TRUE(live.stored.is_stored);
    TEST_ASSERT_EQUAL_MEMORY(&wanted, live.in_force, sizeof wanted);
}

TEST(test_a_store_is_there_where_any_unit_can_be_read)
{
    TEST_ASSERT_TRUE(live_config_can_store(&live));
    for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
        for (uint32_t slot = 0U; slot < HAL_STORE_SLOTS; slot++) {
            flash.units[slot][unit].half_done = true;
            flash.units[slot][unit].half = HAL_HOST_FLASH_UNREADABLE;
        }
    }
    TEST_ASSERT_FALSE(live_config_can_store(&live));
    flash.units[1][200].half_done = false;
    TEST_ASSERT_TRUE(live_config_can_store(&live));
}
