/* SPDX-License-Identifier: MIT */
/*
 * Any bytes as a configuration block, and a drive that is started with it where it is taken.
 *
 * The input is the block; what is missing is that of the image, and its CRCs are made right, so
 * that the settings are looked at. With an odd number of bytes they are left as they are.
 */
#include "config_block.h"
#include "config_guard.h"
#include "drive.h"
#include "drive_config.h"
#include "fuzzed.h"

#include "about.h"

#include <string.h>

#define TICKS (64U)

static const about_t ABOUT = {DRIVE_ABOUT};

static void drive_runs(const drive_cfg_t *cfg)
{
    drive_t drive;
    drive_out_t out = {0};
    const drive_in_t in = {.command.request = DRIVE_REQUEST_RUN};

    HOLDS(drive_init(&drive, cfg) == NULL, "a block that is good starts the drive");
    for (uint32_t k = 0U; k < TICKS; k++) {
        drive_step(&drive, &in, &out);
    }
}

static void verdict_holds(const config_block_t *block)
{
    const config_block_verdict_t verdict = config_block_check(block, &ABOUT.identity);

    HOLDS((verdict.fault == CONFIG_BLOCK_BAD_SETTING) == (verdict.setting != NULL),
          "a bad setting is named, and nothing else");
    if (verdict.fault == CONFIG_BLOCK_GOOD) {
        HOLDS(block->about.name[CONFIG_BLOCK_NAME_BYTES - 1U] == '\0', "a name ends");
        drive_runs(&block->cfg);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const size_t count = (size < CONFIG_BLOCK_BYTES) ? size : CONFIG_BLOCK_BYTES;
    config_about_t facts = {.pole_pairs = ABOUT.rotation.pole_pairs,
                            .speed_max_rpm = ABOUT.speed_max_rpm};
    uint8_t bytes[CONFIG_BLOCK_BYTES];
    uint8_t back[CONFIG_BLOCK_BYTES];
    config_block_t block;

    config_block_make(&block, &ABOUT.identity, &facts, &DRIVE_CONFIG);
    config_block_encode(&block, bytes);
    if (count > 0U) {
        memcpy(bytes, data, count);
    }
    config_block_decode(&block, bytes);
    config_block_encode(&block, back);
    HOLDS(memcmp(bytes, back, sizeof bytes) == 0, "a block has the bytes that it was read from");
    verdict_holds(&block);
    if ((size % 2U) == 0U) {
        drive_cfg_t settings = block.cfg;
        config_about_t about = block.about;

        about.name[CONFIG_BLOCK_NAME_BYTES - 1U] = '\0';
        settings.crc = config_guard_crc(&settings);
        config_block_make(&block, &ABOUT.identity, &about, &settings);
        verdict_holds(&block);
    }
    return 0;
}
