/* SPDX-License-Identifier: MIT */
/*
 * The binding of hal.h to a recording: the measurements come from a recorded frame, and the output
 * for timer and gates is kept for the recording of results. Runs on any Cortex-M that has 256 KiB
 * of flash at 0 and 16 KiB of RAM at 0x20000000.
 */
#ifndef HAL_MPS2_H
#define HAL_MPS2_H

#include "hal.h"

#include <stdint.h>

struct hal {
    drive_in_t measured; /* input frame of this tick; its command is not used */
    drive_out_t applied; /* output frame of this tick */
    uint32_t ticks;
};

/* Sets the frame that the next hal_sample() gives. Call before each control_isr(). */
void hal_mps2_feed(hal_t *hal, const drive_in_t *in);

#endif
