/* SPDX-License-Identifier: MIT */
/*
 * The configuration while the drive runs: the block in force, and a prepared block that replaces it
 * at a tick.
 *
 * The first word that is written begins the preparation: at that moment the prepared block becomes
 * a copy of the block in force. So a writer writes only the words that differ, and the CRCs. An
 * apply ends the preparation, whatever its verdict. When the change has been taken, a second apply
 * with the same CRC gets the same verdict again.
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
 * Result of a request. why: the reason for its refusal; NULL: it is done. path: the setting that
 * the reason is about; NULL: there is none. Both are constant texts.
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
    about_t about;          /* facts of motor and board for the block in force */
    stored_config_t stored; /* stored.block is the first block in force */
    config_block_t other;   /* the second block */
    config_block_t *in_force;
    config_block_t *prepared;      /* the block that is not in force */
    live_config_verdict_t applied; /* verdict of the last apply */
    uint32_t applied_crc;          /* CRC with which the last apply was asked for */
    /* limits of the block that was taken unlocked last; before that, of the first block */
    config_lock_t lock;
    bool preparing; /* a word was written since the last apply */
    bool pending;   /* the prepared block waits for the tick that takes it */
} live_config_t;

/*
 * Chooses the block with which the drive is to start, live->in_force->cfg: the stored block or the
 * image's block (stored_config.h). Call before the control interrupt is enabled. `app` may be
 * initialised later. All arguments must outlive the drive.
 */
void live_config_init(live_config_t *live, app_t *app, hal_t *hal, const about_t *about,
                      const drive_cfg_t *cfg);

/*
 * Writes word `at` of the prepared block. Refuses a word beyond the end of the block, and any word
 * while a change has not been taken.
 */
live_config_verdict_t live_config_write(live_config_t *live, uint32_t at, uint32_t word);

/* Forgets the last apply and the words that were written since then. */
void live_config_forget(live_config_t *live);

/*
 * The prepared block replaces the block in force, as a whole, at a tick within a slow period. crc:
 * CRC of its configuration. Refused if no block was prepared, or the prepared block has another
 * CRC, is damaged or not for this image, changes a setting that the drive cannot change in its
 * state, or protects less and nobody has unlocked that (commander_unlock()). Also refused if the
 * control tick does not run.
 */
live_config_verdict_t live_config_apply(live_config_t *live, uint32_t crc);

/*
 * The configuration of the image replaces the one in force, under the conditions of
 * live_config_apply(). If the drive is at rest, this needs no unlocking.
 */
live_config_verdict_t live_config_restore(live_config_t *live);

/* Whether the board has a store: whether any unit of it can be read. */
bool live_config_can_store(const live_config_t *live);

/* Stores the block in force (stored_config.h). */
live_config_verdict_t live_config_store(live_config_t *live);

/*
 * Call once a tick or more often. When a tick has taken the prepared block, this makes it the block
 * in force, and copies the facts of its motor to `about`. The target speed is limited to the speed
 * limit of that motor. If the change has sent the drive to INIT, the command becomes speed 0
 * without a request.
 */
void live_config_step(live_config_t *live);

#endif
