/* SPDX-License-Identifier: MIT */
#include "stored_config.h"

#include <stddef.h>

static bool is_good(stored_config_t *stored, const config_identity_t *identity)
{
    stored->verdict = config_block_check(&stored->block, identity);
    return stored->verdict.fault == CONFIG_BLOCK_GOOD;
}

void stored_config_load(stored_config_t *stored, hal_t *hal, const drive_cfg_t *cfg, about_t *about)
{
    stored->verdict = (config_block_verdict_t){.fault = CONFIG_BLOCK_GOOD};
    store_find(&stored->store, hal);
    stored->is_stored =
        store_read(&stored->store, &stored->block) && is_good(stored, &about->identity);
    if (!stored->is_stored) {
        config_about_t of_image = {.pole_pairs = about->rotation.pole_pairs,
                                   .speed_max_rpm = about->speed_max_rpm};

        config_block_name(of_image.name, about->name);
        config_block_make(&stored->block, &about->identity, &of_image, cfg);
    }
    about->name = stored->block.about.name;
    about->rotation.pole_pairs = stored->block.about.pole_pairs;
    about->speed_max_rpm = stored->block.about.speed_max_rpm;
}

/* Why an image does not take a block. */
static const char *reason(config_block_fault_t fault)
{
    const char *text = NULL;

    switch (fault) {
    case CONFIG_BLOCK_GOOD:
        break;
    case CONFIG_BLOCK_NO_BLOCK:
    case CONFIG_BLOCK_BROKEN:
        text = "the block is damaged";
        break;
    case CONFIG_BLOCK_OTHER_VERSION:
    case CONFIG_BLOCK_OTHER_LENGTH:
    case CONFIG_BLOCK_OTHER_SCHEMA:
        text = "the block was made for another firmware";
        break;
    case CONFIG_BLOCK_OTHER_BOARD:
        text = "the block was made for another board";
        break;
    default: /* CONFIG_BLOCK_BAD_SETTING */
        text = "the block has a setting that the drive does not take";
        break;
    }
    return text;
}

void stored_config_tell(text_t *text, const stored_config_t *stored)
{
    const config_block_verdict_t *const verdict = &stored->verdict;

    if (stored->is_stored) {
        text_add(text, "configuration: the stored one");
    } else if (verdict->fault == CONFIG_BLOCK_GOOD) {
        text_add(text, "configuration: that of the image, none is stored");
    } else {
        text_add(text, "configuration: that of the image, not the stored one: ");
        text_add(text, reason(verdict->fault));
    }
    if (verdict->setting != NULL) {
        text_add(text, ": ");
        text_add(text, verdict->setting);
    }
}

/* With open gates, and nothing in force that closes them. */
static bool rests(const app_t *app)
{
    const drive_state_t state = app->drive.state;
    const bool calm = (state == DRIVE_STATE_READY) || (state == DRIVE_STATE_FAULT);

    return calm && !app->out.gate_enable && (command_mailbox_take(&app->mailbox).request == 0U);
}

const char *stored_config_save(stored_config_t *stored, const app_t *app,
                               const config_identity_t *identity, const config_block_t *block)
{
    const char *why;

    if (rests(app)) {
        why = reason(config_block_check(block, identity).fault);
    } else {
        why = "the drive does not rest with open gates; stop it first";
    }
    if (why == NULL) {
        why = store_write(&stored->store, block);
    }
    return why;
}
