/* SPDX-License-Identifier: MIT */
#include "stored_config.h"

#include "commander.h"
#include "config_ceiling.h"

#include <stddef.h>

/*
 * If the image has an example motor, its motor's limits are not ceilings for the block, because
 * nobody has said which limits the connected motor has.
 */
config_block_verdict_t stored_config_check(const config_block_t *block, const about_t *about,
                                           const drive_cfg_t *cfg)
{
    config_block_verdict_t verdict = config_block_check(block, &about->identity);

    if (verdict.fault == CONFIG_BLOCK_GOOD) {
        verdict.setting = config_ceiling_crossed(cfg, &block->cfg, about->is_example == 0U);
        verdict.fault = (verdict.setting == NULL) ? CONFIG_BLOCK_GOOD : CONFIG_BLOCK_ABOVE_CEILING;
    }
    return verdict;
}

static bool is_good(stored_config_t *stored, const about_t *about, const drive_cfg_t *cfg)
{
    stored->verdict = stored_config_check(&stored->block, about, cfg);
    return stored->verdict.fault == CONFIG_BLOCK_GOOD;
}

void stored_config_of_image(config_block_t *block, const about_t *about, const drive_cfg_t *cfg)
{
    config_about_t facts = {.pole_pairs = about->rotation.pole_pairs,
                            .speed_max_rpm = about->speed_max_rpm,
                            .is_example = about->is_example};

    config_block_name(facts.name, about->name);
    config_block_make(block, &about->identity, &facts, cfg);
}

void stored_config_about(const config_block_t *block, about_t *about)
{
    about->name = block->about.name;
    about->rotation.pole_pairs = block->about.pole_pairs;
    about->speed_max_rpm = block->about.speed_max_rpm;
    about->is_example = block->about.is_example;
}

void stored_config_load(stored_config_t *stored, hal_t *hal, const drive_cfg_t *cfg, about_t *about)
{
    stored->verdict = (config_block_verdict_t){.fault = CONFIG_BLOCK_GOOD};
    store_find(&stored->store, hal);
    stored->is_stored = store_read(&stored->store, &stored->block) && is_good(stored, about, cfg);
    if (!stored->is_stored) {
        stored_config_of_image(&stored->block, about, cfg);
    }
    stored_config_about(&stored->block, about);
}

const char *stored_config_reason(config_block_fault_t fault)
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
    case CONFIG_BLOCK_ABOVE_CEILING:
        text =
            "protects less than the files that this image was made from; a new image sets another limit";
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
        text_add(text, stored_config_reason(verdict->fault));
    }
    if (verdict->setting != NULL) {
        text_add(text, ": ");
        text_add(text, verdict->setting);
    }
}

const char *stored_config_save(stored_config_t *stored, const app_t *app,
                               const config_identity_t *identity, const config_block_t *block)
{
    const char *why;

    if (commander_is_at_rest(app)) {
        why = stored_config_reason(config_block_check(block, identity).fault);
    } else {
        why = "the drive does not rest with open gates; stop it first";
    }
    if (why == NULL) {
        why = store_write(&stored->store, block);
    }
    return why;
}
