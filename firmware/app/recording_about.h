/* SPDX-License-Identifier: MIT */
/* The facts that a recording has beside its frames, for console and black box. Pure. */
#ifndef RECORDING_ABOUT_H
#define RECORDING_ABOUT_H

#include "about.h"
#include "hal.h"
#include "recorder_dump.h"

/* The recording was not cut by the reset. */
recorder_about_t recording_about(const about_t *about, hal_reset_t reset);

#endif
