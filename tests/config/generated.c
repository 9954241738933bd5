/* SPDX-License-Identifier: MIT */
/* Includes one generated header, as a target does; compiled once a header. */
#include CONFIG_HEADER

const drive_cfg_t *CONFIG_FUNCTION(void);

const drive_cfg_t *CONFIG_FUNCTION(void)
{
    return &DRIVE_CONFIG;
}
