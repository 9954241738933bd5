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
    const char *name; /* names of motor, board and tuning */
    /*
     * Build-id of the image, RECORDER_BUILD_WORDS words. NULL: the image has no build-id. Not part
     * of DRIVE_ABOUT.
     */
    const uint32_t *build;
    config_identity_t identity; /* schema and board of the blocks that this image accepts */
    units_rotation_t rotation;
    int32_t speed_max_rpm; /* highest speed of the shaft, for both directions */
    /* 1: an example motor, so nobody has said which motor is connected; else 0 */
    uint32_t is_example;
    uint32_t baud; /* bits per second of the serial line; a byte takes 10 bits */
    /* reading of adc_ia and adc_ib at zero current: half of the converter's range */
    uint16_t current_zero_count;
    /* current at which a reading is current_zero_count counts above current_zero_count */
    uint32_t current_full_scale_ua;
    uint32_t bus_full_scale_uv;
    temperature_line_t temperature; /* converts adc_temperature to °C */
} about_t;

#endif
