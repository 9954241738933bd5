/* SPDX-License-Identifier: MIT */
/* Input frames of one bad signal each, for the limits of the example configuration. */
#ifndef FAULT_FRAMES_H
#define FAULT_FRAMES_H

#include "drive.h"

static inline void make_break(drive_in_t *in)
{
    in->flags = DRIVE_FLAG_BREAK;
}

static inline void make_overcurrent(drive_in_t *in)
{
    in->adc_ia = 4000U; /* 15616 of Q15, limit 14746 */
}

static inline void make_overvoltage(drive_in_t *in)
{
    in->adc_bus = 3642U; /* 29136, limit 29127 */
}

static inline void make_undervoltage(drive_in_t *in)
{
    in->adc_bus = 1820U; /* 14560, limit 14564 */
}

#endif
