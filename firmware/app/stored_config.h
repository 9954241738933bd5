/* SPDX-License-Identifier: MIT */
/*
 * The configuration that the drive runs with: the stored block where it is good for this image,
 * else that of the image.
 *
 * A start takes a block that is whole, of this schema and of this board, whose settings pass
 * config_check.h, and that protects no less than the image (config_ceiling.h). The block is copied
 * to the RAM: one that is stored later acts from the next start on, and the drive that runs keeps
 * its own.
 */
#ifndef STORED_CONFIG_H
#define STORED_CONFIG_H

#include "about.h"
#include "app.h"
#include "config_block.h"
#include "store.h"
#include "text.h"

#include <stdbool.h>

typedef struct {
    store_t store;
    config_block_t block;           /* what the drive is started with */
    bool is_stored;                 /* it is the stored one */
    config_block_verdict_t verdict; /* of the stored one, where there is one */
} stored_config_t;

/*
 * Chooses the block. `cfg` is the configuration of the image; `about`, that of the image, gets the
 * name and the facts of the motor of the block that was chosen. The drive is then started with
 * stored->block.cfg. Context: background, before the control interrupt is enabled. All that is
 * given outlives the drive.
 */
void stored_config_load(stored_config_t *stored, hal_t *hal, const drive_cfg_t *cfg,
                        about_t *about);

/* Makes the block of the configuration of an image. Context: background. */
void stored_config_of_image(config_block_t *block, const about_t *about, const drive_cfg_t *cfg);

/*
 * Sets the name and the facts of the motor of `about` to those of a block, which outlives it.
 * Context: background.
 */
void stored_config_about(const config_block_t *block, about_t *about);

/*
 * Whether this image may run with a block: config_block_check(), then the ceilings of the image.
 * `about` and `cfg` are the image's.
 */
config_block_verdict_t stored_config_check(const config_block_t *block, const about_t *about,
                                           const drive_cfg_t *cfg);

/* Why an image does not take a block, as a constant text; NULL for CONFIG_BLOCK_GOOD. */
const char *stored_config_reason(config_block_fault_t fault);

/*
 * Adds what was chosen, and why the stored block was not, as one line without its end. Context:
 * background.
 */
void stored_config_tell(text_t *text, const stored_config_t *stored);

/*
 * Stores a block; the next start takes it. Returns NULL, or why it is refused, a constant text: the
 * drive does not rest with open gates, the block is none for this image, or the flash does not
 * work. `identity`: that of this image. The control interrupt stands still meanwhile, some 35 ms on
 * an STM32G431. Context: background.
 */
const char *stored_config_save(stored_config_t *stored, const app_t *app,
                               const config_identity_t *identity, const config_block_t *block);

#endif
