/* SPDX-License-Identifier: MIT */
/*
 * The configuration while the drive runs: the block in force, and a prepared block that replaces it
 * at a tick.
 *
 * Preparing begins with the first word that is written: the prepared block is then a copy of the
 * block in force. So a writer writes only the words that differ, and the CRCs. An apply ends the
 * preparation, whatever its verdict. A second apply with the same CRC, once the change is taken,
 * gets the same verdict again.
 *
 * Context: background; a tick may come at any instruction.
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
 * Why something is refused. why: the reason; NULL: it is done. path: the setting that the reason is
 * about; NULL: none. Both are constant texts.
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
    uint32_t applied_crc;          /* CRC with which the last apply was asked for */
    config_lock_t lock;            /* of the block that was unlocked last, or of the first one */
    bool preparing;                /* a word was written since the last apply */
    bool pending;                  /* the prepared block waits for the tick that takes it */
} live_config_t;

/*
 * Chooses the block with which the drive is to start, live->in_force->cfg: the stored block or the
 * image's block (stored_config.h). Call before the control interrupt is enabled. `app` may be
 * initialised later. All arguments must outlive the drive.
 */
void live_config_init(live_config_t *live, app_t *app, hal_t *hal, const about_t *about,
                      const drive_cfg_t *cfg);

/*
 * Writes word `at` of the prepared block. Refused beyond the end of the block, and while a change
 * has not been taken.
 */
live_config_verdict_t live_config_write(live_config_t *live, uint32_t at, uint32_t word);

/* Forgets the last apply and the words that were written since then. */
void live_config_forget(live_config_t *live);

/*
 * The prepared block replaces the block in force, as a whole, at a tick within a slow period. crc:
 * of its configuration. Refused when the prepared block has another CRC, is not good or not for
 * this image, changes a setting that the drive cannot change in its state, or protects less and
 * nobody has unlocked that (commander_unlock()), and when the control tick does not run.
 */
live_config_verdict_t live_config_apply(live_config_t *live, uint32_t crc);

/*
 * The configuration of the image replaces the one in force, under the same conditions; at rest it
 * needs no unlocking.
 */
live_config_verdict_t live_config_restore(live_config_t *live);

/* Whether the board has a store: whether any unit of it can be read. */
bool live_config_can_store(const live_config_t *live);

/* Stores the block in force (stored_config.h). */
live_config_verdict_t live_config_store(live_config_t *live);

/*
 * Call once a tick or more often. When a tick has taken the prepared block, this makes it the block
 * in force, and copies the facts of its motor to `about`. The target speed is limited to the speed
 * limit of that motor. If the drive has begun anew, the command becomes speed 0 without a request.
 */
void live_config_step(live_config_t *live);

#endif
