/* SPDX-License-Identifier: MIT */
#include "hal_mps2.h"

void hal_mps2_feed(hal_t *hal, const drive_in_t *in)
{
    hal->measured = *in;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    *in = hal->measured;
    hal->ticks++;
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    hal->applied = *out;
}

void hal_open_gates(hal_t *hal)
{
    hal->applied.gate_enable = false;
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}
