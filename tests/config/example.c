/* SPDX-License-Identifier: MIT */
/* The configuration that the unit tests of the firmware write out by hand. */
#include "example_cfg.h"

drive_cfg_t example_cfg(void);

drive_cfg_t example_cfg(void)
{
    return example_drive_cfg_with_startup();
}
