/* SPDX-License-Identifier: MIT */
/*
 * What is measured at one instant, per unit. An instant_t lives for one tick: tick.c makes it and
 * hands it to the parts of the drive.
 */
#ifndef INSTANT_H
#define INSTANT_H

#include "fx.h"
#include "io.h"
#include "protection.h"
#include "state.h"

typedef struct {
    sample_t sample;
    /* measured current in the frame of θ̂, Q15 of I_b, ±34400; 0 with open gates */
    dq_t along_rotor;
    /* the same in the frame of the imposed vector; 0 in RUN too */
    dq_t along_vector;
} instant_t;

/*
 * Returns the samples of a frame per unit, saturated. The currents mean nothing before the
 * calibration has ended. Pure, any context; in the background the frame and the drive are of one
 * tick only if no tick came in between.
 */
static inline sample_t instant_sample(const drive_t *drive, const drive_in_t *in)
{
    const sampling_cfg_t *const cfg = &drive->cfg->sampling;
    const uint32_t a = (uint32_t)in->adc_ia << cfg->current_shift;
    const uint32_t b = (uint32_t)in->adc_ib << cfg->current_shift;
    const uint32_t bus = (uint32_t)in->adc_bus << cfg->bus_shift;

    const sample_t sample = {
        fx_sat15((int32_t)a - drive->sensors.offset_a),
        fx_sat15((int32_t)b - drive->sensors.offset_b),
        fx_usat15((int32_t)bus),
    };

    return sample;
}

#endif
