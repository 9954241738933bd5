/* SPDX-License-Identifier: MIT */
/* The configuration that the unit tests of the firmware write out by hand, with an input. */
#include "example_cfg.h"

drive_cfg_t example_cfg(void);

drive_cfg_t example_cfg(void)
{
    drive_cfg_t cfg = example_drive_cfg_with_startup();

    cfg.input = example_input_cfg();
    return cfg;
}
