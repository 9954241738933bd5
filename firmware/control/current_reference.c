/* SPDX-License-Identifier: MIT */
#include "current_reference.h"

#include "trig.h"

#define CURRENT_END (16384)
#define Q15_BITS (15U)
/*
 * Largest c, Q15 of I_b, with which MTPA is computed. With a larger c, MTPA would give at most 0.2
 * % more torque than i_d = 0.
 */
#define MTPA_END (131071)
#define MTPA_SQUARE_MAX (32767)
#define MTPA_SHIFT (2U)
#define MTPA_SCALE (4)
#define Q13_TO_C (16384) /* half of 2^15, because c is φ over twice the saliency */
/* Factor of the squared current under the root of MTPA, for a given i_q or a given |i|. */
#define OF_TORQUE (1) /* for i_q: i_d = −i_q²/(c + √(c² + i_q²)) */
#define OF_VECTOR (2) /* for |i|: i_d = −i²/(c + √(c² + 2·i²)) */
/*
 * Factor of the excess by which the least i_d* falls below 0. With floor_shift 1 it falls by twice
 * the change of |i_q*|. The i_d* of MTPA is −|i_q*| at the lowest, so the least i_d* gets below it
 * and MTPA takes over.
 */
#define GIVES_WAY (4)
#define FALL_SHIFT (2U) /* i_d* falls by 1/4 of its distance to the limit in a slow period */
#define RISE_SHIFT (3U) /* i_d* rises by 1/8 of this distance */

/*
 * Returns the i_d* that keeps the current vector large enough; below 0 where i_q* alone is enough.
 * i_d* rises while i_q*, which falls faster, still flows. So the vector is never shorter than 0.89
 * of `floor` with floor_shift 1, and 0.71 of it with floor_shift 0. Below floor_speed only i_q*
 * carries a load. The dead time of i_q* acts across the EMF, where it turns the angle by some
 * degrees; the dead time of an i_d* would turn the angle further.
 *
 * Where i_q* alone is enough, the result falls below 0 in proportion to the excess. So MTPA takes
 * over without a jump.
 */
static int32_t least_current_d(const current_reference_cfg_t *cfg, const current_reference_in_t *in)
{
    const int32_t torque = fx_abs(in->present.q);
    const int32_t lacking = cfg->floor - fx_asr(torque, cfg->floor_shift);
    int32_t least = -CURRENT_END;

    if (fx_abs(in->speed) >= in->floor_speed) {
        least = (lacking < 0) ? (lacking * GIVES_WAY) : lacking;
    }
    return least;
}

/*
 * Returns i_d of MTPA at this current. saliency_q13: X_q − X_d > 0. squares: OF_TORQUE if `current`
 * is i_q, OF_VECTOR if it is |i|.
 */
static int32_t most_torque_d(const current_loop_cfg_t *model, int32_t saliency_q13, int32_t current,
                             int32_t squares)
{
    const int32_t magnet = (model->emf_q13 * Q13_TO_C) / saliency_q13; /* c, Q15 of I_b */
    int32_t depth = 0;

    if (magnet <= MTPA_END) {
        const bool large = magnet > MTPA_SQUARE_MAX;
        const uint32_t shift = large ? MTPA_SHIFT : 0U;
        const int32_t scale = large ? MTPA_SCALE : 1;
        const int32_t c = fx_min(fx_asr(magnet, shift), MTPA_SQUARE_MAX);
        const int32_t size = fx_asr(fx_abs(current), shift);
        const int32_t square = (c * c) + (squares * size * size);
        const int32_t root = (int32_t)trig_sqrt((uint32_t)square);
        const int32_t whole = fx_max((c + root) * scale, 1);

        depth = (current * current) / whole;
    }
    return -fx_min(depth, CURRENT_END);
}

static int32_t mtpa_d(const current_loop_cfg_t *model, int32_t current, int32_t squares)
{
    const int32_t saliency_q13 = model->reactance_q_q13 - model->reactance_d_q13;

    return (saliency_q13 > 0) ? most_torque_d(model, saliency_q13, current, squares) : 0;
}

/* Returns the larger i_d* of the least current and of MTPA. */
static int32_t wanted_d(const current_reference_cfg_t *cfg, const current_loop_cfg_t *model,
                        const current_reference_in_t *in)
{
    const int32_t most = (cfg->most_torque != 0U) ? mtpa_d(model, in->present.q, OF_TORQUE) : 0;

    return fx_max(least_current_d(cfg, in), most);
}

int32_t current_reference_d(const current_reference_cfg_t *cfg, const current_loop_cfg_t *model,
                            const current_reference_in_t *in)
{
    const int32_t wanted = (in->imposed != 0) ? in->imposed : wanted_d(cfg, model, in);
    const int32_t present = in->present.d;
    const int32_t rise = cfg->slope * in->ticks;
    const int32_t drop = cfg->slope_down * in->ticks;
    const int32_t least = fx_max(present - fx_max(rise, drop), fx_min(present, cfg->floor) - drop);

    return fx_clamp(wanted, least, present + rise);
}

/*
 * The limit of i_d* depends on i_q*, and the range of i_q* depends on i_d*: at the largest torque a
 * step of one of them changes the other by up to three times as much. So in a slow period i_d*
 * moves only by a part of its distance to the limit.
 */
static int32_t weakened_d(int32_t present, int32_t limit)
{
    const uint32_t shift = (limit > present) ? RISE_SHIFT : FALL_SHIFT;

    return fx_approach(present, limit, shift);
}

current_reference_t current_reference_weakened(weakening_t *weakening, const weakening_in_t *in,
                                               int32_t next_d)
{
    const weakening_limits_t limits = weakening_step(weakening, in, next_d);

    return (current_reference_t){.d = fx_min(next_d, weakened_d(in->reference.d, limits.upper)),
                                 .reach = limits.reach};
}

torque_range_t current_reference_range(const current_reference_cfg_t *cfg, torque_range_t range,
                                       const current_reference_t *reference, int32_t current_max)
{
    const bool beside = (reference->d > cfg->floor) || (reference->d < 0);
    torque_range_t left = range;

    if (beside || (reference->reach < CURRENT_REFERENCE_ALL)) {
        const int32_t square =
            fx_max((current_max * current_max) - (reference->d * reference->d), 0);
        const int32_t rest = beside ? (int32_t)trig_sqrt((uint32_t)square) : CURRENT_REFERENCE_ALL;
        const int32_t room = fx_min(reference->reach, rest);

        left = (torque_range_t){.lower = fx_max(range.lower, -room),
                                .upper = fx_min(range.upper, room)};
    }
    return left;
}

int32_t current_reference_flux(const current_loop_cfg_t *model, int32_t current_d)
{
    const int32_t difference = model->reactance_d_q13 - model->reactance_q_q13;
    const int32_t of_reluctance = fx_asr(difference * current_d, Q15_BITS);

    return fx_clamp(model->emf_q13 + of_reluctance, 1, FX_Q15_MAX);
}

int32_t current_reference_torque_max(const current_reference_cfg_t *cfg,
                                     const current_loop_cfg_t *model, int32_t current_max)
{
    const int32_t d = (cfg->most_torque != 0U) ? mtpa_d(model, current_max, OF_VECTOR) : 0;
    const int32_t square = fx_max((current_max * current_max) - (d * d), 0);
    const int32_t q = (int32_t)trig_sqrt((uint32_t)square);

    return current_reference_torque(fx_min(q, CURRENT_END), current_reference_flux(model, d));
}

int32_t current_reference_q(int32_t torque_q28, int32_t flux_q13)
{
    return fx_clamp(torque_q28 / flux_q13, -CURRENT_END, CURRENT_END);
}
