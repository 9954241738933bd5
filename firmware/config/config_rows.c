/* SPDX-License-Identifier: MIT */
#include "config_rows.h"

#include "words.h"

#include <stddef.h>

/* A setting is a word, whose lowest byte comes first in memory as in a block. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "words_get() reads the memory of the host");

uint32_t config_rows(const config_row_t **rows)
{
    // cppcheck-suppress misra-c2012-20.10 ; D4: the name of a row is its own path
#define ROW(path, lo, hi, use) \
    {#path, (lo), (hi), (uint16_t)offsetof(drive_cfg_t, path), (uint8_t)(use)},
#define CFG(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, CONFIG_USE_ALWAYS)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, CONFIG_USE_STARTUP)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    ROW(path, lo, hi, CONFIG_USE_ALWAYS) \
    ROW(path, lo_startup, hi, CONFIG_USE_STARTUP)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) \
    ROW(path, lo, hi, CONFIG_USE_VOLTAGE_DRIVE)
    static const config_row_t table[] = {
    // cppcheck-suppress misra-c2012-20.1 ; D5: the rows of the table are those of the file
#include "cfg.def"
    };

    *rows = table;
    return (uint32_t)(sizeof(table) / sizeof(table[0]));
}

int32_t config_row_value(const config_row_t *row, const drive_cfg_t *cfg)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;

    return fx_signed(words_get(&bytes[row->offset]));
}
