/* SPDX-License-Identifier: MIT */
#include "config_change.h"

#include <stdbool.h>
#include <stddef.h>

/*
 * Returns `before` if it is not NULL: an earlier setting differs. Otherwise returns `path` if this
 * setting differs, and NULL if it does not.
 */
static const char *first_different(const char *before, const char *path, bool differs)
{
    const char *result = before;

    if ((before == NULL) && differs) {
        result = path;
    }
    return result;
}

/* Returns the path of the first REST row in which the configurations differ, or NULL. */
static const char *compare_rows(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const char *refused = NULL;

    // cppcheck-suppress misra-c2012-20.7 ; D3: a path is a member, which no brackets may enclose
    // cppcheck-suppress misra-c2012-20.10 ; D4: what is returned is the row's own path
#define REST(path) refused = first_different(refused, #path, from->path != to->path);
#define RUN(path)
#define CFG(path, when, lo, hi, quantity, meaning) when(path)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) when(path)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) when(path)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) when(path)
    // cppcheck-suppress misra-c2012-20.1 ; D5: the rows are the statements here
#include "cfg.def"
    return refused;
}

const char *config_change_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const bool started = from->startup.current_hold != 0;
    const bool starts = to->startup.current_hold != 0;

    /*
     * Without a start-up the drive cannot leave the states of a start-up, and nothing has checked
     * the settings that these states read.
     */
    return first_different(compare_rows(from, to), "startup.current_hold", started != starts);
}
