/* SPDX-License-Identifier: MIT */
/*
 * The configuration that the drive runs with: the stored block if this image may run with it, else
 * the block of the image.
 *
 * A start takes a block that is whole, is of this schema and this board, has settings that pass
 * config_check.h, and protects no less than the image (config_ceiling.h). The start copies the
 * block to the RAM. So a block that is stored later is used from the next start on; the running
 * drive keeps its configuration.
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
    config_block_t block;           /* the block with which the drive is started */
    bool is_stored;                 /* `block` is the stored block, not the block of the image */
    config_block_verdict_t verdict; /* verdict on the stored block, if there is one */
} stored_config_t;

/*
 * Chooses the block. `cfg` is the configuration of the image. `about` contains the facts of the
 * image; the name and the motor's facts are replaced by those of the chosen block. Then start the
 * drive with stored->block.cfg. Context: background, before the control interrupt is enabled. All
 * arguments must outlive the drive.
 */
void stored_config_load(stored_config_t *stored, hal_t *hal, const drive_cfg_t *cfg,
                        about_t *about);

/* Makes a block from the configuration of an image. Context: background. */
void stored_config_of_image(config_block_t *block, const about_t *about, const drive_cfg_t *cfg);

/*
 * Copies the name and the motor's facts from a block to `about`. The block must outlive `about`.
 * Context: background.
 */
void stored_config_about(const config_block_t *block, about_t *about);

/*
 * Whether this image may run with a block: config_block_check(), then the ceilings of the image.
 * `about` and `cfg` belong to the image.
 */
config_block_verdict_t stored_config_check(const config_block_t *block, const about_t *about,
                                           const drive_cfg_t *cfg);

/*
 * Returns the reason why an image does not accept a block, a constant text; NULL for
 * CONFIG_BLOCK_GOOD.
 */
const char *stored_config_reason(config_block_fault_t fault);

/*
 * Adds one line, without its end: which block was chosen, and why the stored block was not.
 * Context: background.
 */
void stored_config_tell(text_t *text, const stored_config_t *stored);

/*
 * Stores a block; the next start takes it. Returns NULL, or the reason for a refusal, a constant
 * text: the drive is not at rest with open gates, the block is not for this image, or the flash
 * does not work. identity: schema and board of this image. While the flash is written the control
 * interrupt stands still, some 35 ms on an STM32G431. Context: background.
 */
const char *stored_config_save(stored_config_t *stored, const app_t *app,
                               const config_identity_t *identity, const config_block_t *block);

#endif
