/* SPDX-License-Identifier: MIT */
#include "current_reference.h"

#include "trig.h"

#define CURRENT_END (16384)
#define Q15_BITS (15U)
#define FREE_SIXTEENTHS (15) /* of the voltage, up to which i_d* may take some */

/* The demand is within 1/16 of the largest voltage of this bus: i_d* takes ω·L_d·i_d of it, which the torque needs. */
static bool lacks_voltage(const current_reference_in_t *in)
{
    const int32_t near = fx_asr(in->voltage_max * FREE_SIXTEENTHS, 4U);
    const int32_t square = near * near;

    return transforms_square(in->voltage) > (uint32_t)square;
}

/*
 * i_d* that keeps the current vector large enough. It comes before the torque current is gone, which falls faster: less half of
 * i_q* the vector is never shorter than 0.89 of the least current, and less all of it 0.71. A load below floor_speed is alone
 * there: i_q* has the dead time across the EMF, where it turns the angle by some degrees; i_d* beside it would add its own.
 */
static int32_t least_current_d(const current_reference_cfg_t *cfg, const current_reference_in_t *in)
{
    const int32_t torque = fx_abs(in->present.q);
    const int32_t lacking = cfg->floor - fx_asr(torque, cfg->floor_shift);
    const bool fast = fx_abs(in->speed) >= in->floor_speed;

    return ((lacking > 0) && fast && !lacks_voltage(in)) ? lacking : 0;
}

int32_t current_reference_d(const current_reference_cfg_t *cfg, const current_reference_in_t *in)
{
    const int32_t present = in->present.d;
    const int32_t wanted = (in->imposed != 0) ? in->imposed : least_current_d(cfg, in);
    const int32_t slope = cfg->slope * in->ticks;
    const int32_t slower = cfg->slope_down * in->ticks;

    return fx_max(fx_towards(present, wanted, slope), fx_min(present, cfg->floor) - slower);
}

torque_range_t current_reference_range(const current_reference_cfg_t *cfg, torque_range_t range,
                                       int32_t current_d, int32_t current_max)
{
    torque_range_t left = range;

    if (current_d > cfg->floor) {
        const int32_t square = fx_max((current_max * current_max) - (current_d * current_d), 0);
        const int32_t room = (int32_t)trig_sqrt((uint32_t)square);

        left.upper = fx_min(range.upper, room);
        left.lower = fx_max(range.lower, -room);
    }
    return left;
}

int32_t current_reference_flux(const current_loop_cfg_t *model, int32_t current_d)
{
    const int32_t difference = model->reactance_d_q13 - model->reactance_q_q13;
    const int32_t of_reluctance = fx_asr(difference * current_d, Q15_BITS);

    return fx_clamp(model->emf_q13 + of_reluctance, 1, FX_Q15_MAX);
}

int32_t current_reference_q(int32_t torque_q28, int32_t flux_q13)
{
    return fx_clamp(torque_q28 / flux_q13, -CURRENT_END, CURRENT_END);
}
