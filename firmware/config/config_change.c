/* SPDX-License-Identifier: MIT */
#include "config_change.h"

#include "config_rows.h"

#include <stdbool.h>
#include <stddef.h>

/* The first row that differs and for which the drive has to be at rest. */
static const char *compare_rows(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const config_row_t *rows = NULL;
    const uint32_t count = config_rows(&rows);
    const char *refused = NULL;

    for (uint32_t k = 0U; (k < count) && (refused == NULL); k++) {
        const config_row_t *const row = &rows[k];

        if (row->at_rest && (config_row_value(row, from) != config_row_value(row, to))) {
            refused = row->path;
        }
    }
    return refused;
}

const char *config_change_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const bool started = from->startup.current_hold != 0;
    const bool starts = to->startup.current_hold != 0;
    const char *refused = compare_rows(from, to);

    /* Without a start-up there is no way out of its states, and nothing has checked what they read. */
    if ((refused == NULL) && (started != starts)) {
        refused = "startup.current_hold";
    }
    return refused;
}
