/* SPDX-License-Identifier: MIT */
#include "live_config.h"

#include "commander.h"
#include "config_change.h"

#include <stddef.h>

#define NO_TICK "the control tick does not run"

static const live_config_verdict_t DONE = {NULL, NULL};
static const live_config_verdict_t NONE_PREPARED = {NULL, "no block was prepared"};

void live_config_init(live_config_t *live, app_t *app, hal_t *hal, const about_t *about,
                      const drive_cfg_t *cfg)
{
    live->app = app;
    live->hal = hal;
    live->cfg_of_image = cfg;
    live->about_of_image = about;
    live->about = *about;
    stored_config_load(&live->stored, hal, cfg, &live->about);
    live->in_force = &live->stored.block;
    live->prepared = &live->other;
    config_lock_keep(&live->lock, &live->in_force->cfg);
    live->pending = false;
    live_config_forget(live);
}

/* Whether no control tick runs: a change would never be taken. */
static bool lacks_ticks(const live_config_t *live)
{
    return (hal_ticks(live->hal) == 0U) || hal_health(live->hal).tick_lost;
}

/* Returns why no other block can be prepared now; DONE: one can be prepared. */
static live_config_verdict_t pending_verdict(const live_config_t *live)
{
    live_config_verdict_t verdict = DONE;

    if (live->pending) {
        verdict.why = lacks_ticks(live)
                          ? "the change before waits for the control tick, which does not run"
                          : "the change before has not been taken yet; ask again";
    }
    return verdict;
}

static void begin_preparing(live_config_t *live)
{
    if (!live->preparing) {
        *live->prepared = *live->in_force;
        live->preparing = true;
    }
}

live_config_verdict_t live_config_write(live_config_t *live, uint32_t at, uint32_t word)
{
    live_config_verdict_t verdict = pending_verdict(live);

    if (verdict.why != NULL) {
        /* refused: `verdict` has the reason */
    } else if (at >= CONFIG_BLOCK_WORDS) {
        verdict.why = "the block has no such word";
    } else {
        begin_preparing(live);
        config_block_set_word(live->prepared, at, word);
    }
    return verdict;
}

void live_config_forget(live_config_t *live)
{
    live->preparing = false;
    live->applied = NONE_PREPARED;
    live->applied_crc = 0U;
}

/* Whether this image may run with the prepared block. */
static live_config_verdict_t block_verdict(const live_config_t *live)
{
    const config_block_verdict_t found =
        stored_config_check(live->prepared, live->about_of_image, live->cfg_of_image);

    return (live_config_verdict_t){.path = found.setting, .why = stored_config_reason(found.fault)};
}

/* Whether the drive may change to the prepared block in its present state. */
static live_config_verdict_t change_verdict(const live_config_t *live)
{
    live_config_verdict_t verdict = DONE;

    if (!commander_is_at_rest(live->app)) {
        verdict.path = config_change_refused(&live->in_force->cfg, &live->prepared->cfg);
        verdict.why = (verdict.path == NULL)
                          ? NULL
                          : "cannot change while the drive runs; stop the drive first";
    }
    return verdict;
}

/* Whether the prepared block protects as much as the block in force, by config_lock.h. */
static live_config_verdict_t lock_verdict(const live_config_t *live)
{
    live_config_verdict_t verdict = DONE;

    verdict.path = config_lock_refused(&live->lock, &live->in_force->cfg, &live->prepared->cfg);
    if (verdict.path != NULL) {
        verdict.why = "protects less than what is in force; stop the drive and unlock first";
    }
    return verdict;
}

/*
 * Checks the prepared block, and hands it to the control interrupt. unlocked: the block may protect
 * less.
 */
static live_config_verdict_t change_to_prepared(live_config_t *live, bool unlocked)
{
    live_config_verdict_t verdict = block_verdict(live);

    if ((verdict.why == NULL) && !unlocked) {
        verdict = lock_verdict(live);
    }
    if (verdict.why == NULL) {
        verdict = change_verdict(live);
    }
    if ((verdict.why == NULL) && lacks_ticks(live)) {
        verdict.why = NO_TICK;
    }
    if (verdict.why == NULL) {
        if (unlocked) {
            config_lock_keep(&live->lock, &live->prepared->cfg);
        }
        app_change(live->app, &live->prepared->cfg);
        live->pending = true;
    }
    return verdict;
}

/*
 * Applies the prepared block, and ends the unlocking: it is for one block only, taken or refused.
 */
static live_config_verdict_t apply_prepared(live_config_t *live)
{
    const live_config_verdict_t verdict = change_to_prepared(live, live->app->unlocked);

    commander_lock(live->app);
    return verdict;
}

live_config_verdict_t live_config_apply(live_config_t *live, uint32_t crc)
{
    live_config_verdict_t verdict = pending_verdict(live);

    if (verdict.why != NULL) {
        /* refused: `verdict` has the reason */
    } else if (live->preparing) {
        live->preparing = false;
        live->applied =
            (live->prepared->cfg.crc == crc)
                ? apply_prepared(live)
                : (live_config_verdict_t){NULL, "another block was prepared; write it again"};
        live->applied_crc = crc;
        verdict = live->applied;
    } else {
        verdict = (live->applied_crc == crc) ? live->applied : NONE_PREPARED;
    }
    return verdict;
}

/*
 * Whether two blocks are the same. In a block, the CRC of the configuration follows the
 * configuration. A CRC over data and their own CRC is constant, so the CRC of the block does not
 * depend on the configuration: both CRCs have to agree.
 */
static bool is_same(const config_block_t *one, const config_block_t *other)
{
    return (one->crc == other->crc) && (one->cfg.crc == other->cfg.crc);
}

live_config_verdict_t live_config_restore(live_config_t *live)
{
    live_config_verdict_t verdict = pending_verdict(live);

    if (verdict.why == NULL) {
        live_config_forget(live);
        stored_config_of_image(live->prepared, live->about_of_image, live->cfg_of_image);
        if (!is_same(live->prepared, live->in_force)) {
            verdict = change_to_prepared(live, commander_is_at_rest(live->app));
        }
    }
    return verdict;
}

bool live_config_can_store(const live_config_t *live)
{
    uint8_t bytes[HAL_STORE_UNIT_BYTES];
    bool can = false;

    for (uint32_t slot = 0U; slot < HAL_STORE_SLOTS; slot++) {
        for (uint32_t unit = 0U; (unit < HAL_STORE_UNITS) && !can; unit++) {
            can = hal_store_read(live->hal, slot, unit, bytes);
        }
    }
    return can;
}

live_config_verdict_t live_config_store(live_config_t *live)
{
    live_config_verdict_t verdict = pending_verdict(live);

    if (verdict.why == NULL) {
        verdict.why = stored_config_save(&live->stored, live->app, &live->about_of_image->identity,
                                         live->in_force);
    }
    return verdict;
}

/*
 * Adapts the command to the new configuration. A target is in steps of the motor for which it was
 * given. If the change has sent the drive to INIT, the motor may be another one.
 */
static void adapt_command(const live_config_t *live, const drive_cfg_t *before)
{
    if (config_change_refused(before, &live->in_force->cfg) == NULL) {
        if (commander_source(live->app) != SOURCE_INPUT) {
            commander_upset(live->app); /* an input that runs the motor has the same settings */
        }
        commander_limit_speed(live->app,
                              units_step(&live->about.rotation, live->about.speed_max_rpm));
    } else {
        commander_begin_anew(live->app);
    }
}

void live_config_step(live_config_t *live)
{
    if (live->pending && !app_changes(live->app)) {
        config_block_t *const before = live->in_force;

        live->in_force = live->prepared;
        live->prepared = before;
        live->pending = false;
        stored_config_about(live->in_force, &live->about);
        adapt_command(live, &before->cfg);
    }
}
