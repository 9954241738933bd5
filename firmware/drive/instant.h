/* SPDX-License-Identifier: MIT */
/*
 * What is measured at one instant, per unit. It lives for one tick.
 *
 * Part of the drive; the tick makes it, and hands it on.
 */
#ifndef INSTANT_H
#define INSTANT_H

#include "fx.h"
#include "io.h"
#include "protection.h"
#include "state.h"

typedef struct {
    sample_t sample;
    dq_t current; /* in the frame of the current control, Q15 of I_b, ±34400; 0 with open gates */
} instant_t;

/*
 * Raw counts to per unit, saturated. The currents mean nothing before the calibration has ended.
 * Pure, any context.
 */
static inline sample_t instant_sample(const drive_t *drive, const drive_in_t *in)
{
    const sampling_cfg_t *const cfg = &drive->cfg->sampling;
    const uint32_t a = (uint32_t)in->adc_ia << cfg->current_shift;
    const uint32_t b = (uint32_t)in->adc_ib << cfg->current_shift;
    const uint32_t bus = (uint32_t)in->adc_bus << cfg->bus_shift;

    const sample_t sample = {
        fx_sat15((int32_t)a - drive->offset_a),
        fx_sat15((int32_t)b - drive->offset_b),
        fx_usat15((int32_t)bus),
    };

    return sample;
}

#endif
