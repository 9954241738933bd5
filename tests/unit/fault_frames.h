/* SPDX-License-Identifier: MIT */
/* Input frames of one bad signal each, for the limits of the example configuration. */
#ifndef FAULT_FRAMES_H
#define FAULT_FRAMES_H

#include "drive.h"

static inline void make_break(drive_in_t *frame)
{
    frame->flags = DRIVE_FLAG_BREAK;
}

static inline void make_overcurrent(drive_in_t *frame)
{
    frame->adc_ia = 4000U; /* 15616 of Q15, limit 14746 */
}

static inline void make_overvoltage(drive_in_t *frame)
{
    frame->adc_bus = 3642U; /* 29136, limit 29127 */
}

static inline void make_undervoltage(drive_in_t *frame)
{
    frame->adc_bus = 1820U; /* 14560, limit 14564 */
}

static const struct {
    void (*make)(drive_in_t *frame);
    fault_id_t id;
    drive_state_t first; /* the first state in which it is watched; in all later ones too */
    int32_t value;
    int32_t limit;
} FAULT_FRAMES[] = {
    {make_break, FAULT_BREAK, DRIVE_STATE_INIT, 0, 0},
    {make_overcurrent, FAULT_OVERCURRENT, DRIVE_STATE_RUN, 15616, 14746},
    {make_overvoltage, FAULT_OVERVOLTAGE, DRIVE_STATE_INIT, 29136, 29127},
    {make_undervoltage, FAULT_UNDERVOLTAGE, DRIVE_STATE_RUN, 14560, 14564},
};

#endif
