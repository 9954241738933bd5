/* SPDX-License-Identifier: MIT */
#include "hal_mps2.h"

void hal_mps2_feed(hal_t *hal, const drive_in_t *in)
{
    hal->measured = *in;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    in->adc_ia = hal->measured.adc_ia;
    in->adc_ib = hal->measured.adc_ib;
    in->adc_bus = hal->measured.adc_bus;
    in->flags = hal->measured.flags;
    in->adc_temperature = hal->measured.adc_temperature;
    in->angle = hal->measured.angle;
    hal->ticks++;
}

/* A recorded frame has the angle. */
hal_shaft_t hal_shaft(hal_t *hal)
{
    (void)hal;
    return (hal_shaft_t){0};
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
