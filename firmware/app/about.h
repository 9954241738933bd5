/* SPDX-License-Identifier: MIT */
/*
 * Facts of motor and board for the texts that a person reads. The drive's integers do not contain
 * them.
 *
 * nfconfig writes them into drive_config.h, as the initialisers DRIVE_ABOUT:
 *
 *     static const about_t ABOUT = {DRIVE_ABOUT};
 */
#ifndef ABOUT_H
#define ABOUT_H

#include "config_block.h"
#include "temperature.h"
#include "units.h"

#include <stdint.h>

typedef struct {
    const char *name; /* of motor, board and tuning */
    /*
     * Build-id of the image, RECORDER_BUILD_WORDS words. NULL: it has none. Not part of
     * DRIVE_ABOUT.
     */
    const uint32_t *build;
    config_identity_t identity; /* of the configuration blocks that this image takes */
    units_rotation_t rotation;
    int32_t speed_max_rpm; /* of the shaft, either way */
    uint32_t is_example;   /* as in config_about_t */
    uint32_t baud;         /* bits a second of the serial line, 10 a byte */
    /* reading of adc_ia and adc_ib at no current: half of the converter's range */
    uint16_t current_zero_count;
    /* ±: current of a reading that is current_zero_count counts away from current_zero_count */
    uint32_t current_full_scale_ua;
    uint32_t bus_full_scale_uv;
    temperature_line_t temperature; /* of adc_temperature */
} about_t;

#endif
