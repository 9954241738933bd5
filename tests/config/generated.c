/* SPDX-License-Identifier: MIT */
/* Includes one generated header, as a target does; compiled once a header. */
#include CONFIG_HEADER

#include "about.h"

const drive_cfg_t *CONFIG_FUNCTION(void);
const about_t *ABOUT_FUNCTION(void);

const drive_cfg_t *CONFIG_FUNCTION(void)
{
    return &DRIVE_CONFIG;
}

const about_t *ABOUT_FUNCTION(void)
{
    static const about_t about = {DRIVE_ABOUT};

    return &about;
}
