/* SPDX-License-Identifier: MIT */
/*
 * The configuration while the drive lives: the block in force, and one that is prepared and takes
 * its place at a tick.
 *
 * Preparing begins with the first word that is written: the prepared block is then a copy of the
 * one in force. So a writer needs to write the words that differ, and the CRCs. An apply ends the
 * preparation, whatever comes of it. When it is asked for once more, with the same CRC, its verdict
 * is the same again.
 *
 * Context: background, all of it; a tick may come in between anywhere.
 */
#ifndef LIVE_CONFIG_H
#define LIVE_CONFIG_H

#include "about.h"
#include "app.h"
#include "config_block.h"
#include "config_lock.h"
#include "stored_config.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * Why something is refused: `why` about `path`, a setting, where there is one. Both constant texts;
 * why NULL: it is done.
 */
typedef struct {
    const char *path;
    const char *why;
} live_config_verdict_t;

typedef struct {
    app_t *app;
    hal_t *hal;
    const drive_cfg_t *cfg_of_image;
    const about_t *about_of_image;
    about_t about;          /* of the block in force */
    stored_config_t stored; /* its block is the first one in force */
    config_block_t other;
    config_block_t *in_force;
    config_block_t *prepared;      /* the other one of the two */
    live_config_verdict_t applied; /* of the last apply */
    uint32_t applied_crc;          /* that it was asked for with */
    config_lock_t lock;            /* what was unlocked last, or was there at the start */
    bool preparing;                /* a word was written since the last apply */
    bool pending;                  /* the prepared block waits for the tick that takes it */
} live_config_t;

/*
 * Chooses the block that the drive is to be started with, live->in_force->cfg: the stored one or
 * that of the image (stored_config.h). Before the control interrupt is enabled. `app` may be
 * initialised later. All that is given outlives the drive.
 */
void live_config_init(live_config_t *live, app_t *app, hal_t *hal, const about_t *about,
                      const drive_cfg_t *cfg);

/*
 * Writes word `at` of the prepared block; beyond its end it is refused, and while a change has not
 * been taken.
 */
live_config_verdict_t live_config_write(live_config_t *live, uint32_t at, uint32_t word);

/* The last apply and what was written since then are forgotten. */
void live_config_forget(live_config_t *live);

/*
 * The prepared block, whose configuration has this `crc`, takes the place of the one in force at
 * the next tick, as a whole. Refused when it is another one, not for this image or not good,
 * changes what the drive cannot change in its state, or protects less and nobody has unlocked that
 * (commander_unlock()).
 */
live_config_verdict_t live_config_apply(live_config_t *live, uint32_t crc);

/*
 * The configuration of the image takes the place of the one in force, under the same conditions; at
 * rest it needs no unlocking.
 */
live_config_verdict_t live_config_restore(live_config_t *live);

/* Whether the board has a store: whether any unit of it can be read. */
bool live_config_can_store(const live_config_t *live);

/* Stores the block in force (stored_config.h). */
live_config_verdict_t live_config_store(live_config_t *live);

/*
 * Once a tick or more often: what a tick has taken is in force, and the facts of its motor are
 * those of `about`. The speed that is asked for stays within its limit. Where the drive has begun
 * anew nothing is asked for, and the speed is 0.
 */
void live_config_step(live_config_t *live);

#endif
