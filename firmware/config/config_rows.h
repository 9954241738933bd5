/* SPDX-License-Identifier: MIT */
/* The rows of cfg.def as a table. Within firmware/config. */
#ifndef CONFIG_ROWS_H
#define CONFIG_ROWS_H

#include "drive_cfg.h"

#include <stdint.h>

/* When the range of a row counts. */
typedef enum {
    CONFIG_USE_ALWAYS = 0,
    CONFIG_USE_STARTUP,      /* startup.current_hold is not 0 */
    CONFIG_USE_VOLTAGE_DRIVE /* voltage_drive.enabled is not 0 */
} config_use_t;

typedef struct {
    const char *path; /* in drive_cfg_t */
    /* An unsigned setting has both ends in 0…2^31 − 1: a larger value reads as a negative one. */
    int32_t lowest;
    int32_t highest;
    uint16_t offset; /* in drive_cfg_t, bytes */
    uint8_t use;     /* config_use_t */
} config_row_t;

/*
 * Sets `rows` to the rows, in the order of cfg.def, and returns their number. A row of CFG_BOTH is two here, the second one
 * for the start-up. Pure, any context.
 */
uint32_t config_rows(const config_row_t **rows);

/* Returns the word of the configuration that the row is about. Pure, any context. */
int32_t config_row_value(const config_row_t *row, const drive_cfg_t *cfg);

#endif
