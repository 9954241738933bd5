/* SPDX-License-Identifier: MIT */
#include "weakening.h"

#include "trig.h"

#define CURRENT_END (16384)
/* in 1/16 of the circle's radius: with a larger demand the voltage may decide i_d* */
#define NEAR (15)
#define RESERVE (3) /* in 1/256 of the circle's radius, kept for the current control */
/* in a slow period the integral changes by 1/8 of the unused or missing voltage */
#define INTEGRAL_SHIFT (3U)
#define RIPPLE_SHIFT (6U) /* in a slow period a valley fades by 1/64 of its depth */
#define REST_STEP (80)    /* step of the integral back to 0 in a slow period, Q15 of U_b */
/*
 * Largest change of the integral in a slow period. A demand on the circle's edge unwinds it by the
 * reserve / 2^INTEGRAL_SHIFT, 19 at 310 V of 450 V. So if a disturbance of some slow periods has
 * wound the integral up, it is unwound after about twice as many.
 */
#define VOLTAGE_STEP (32)
#define SHARE_ONE (65536)
#define VOLTS_END (32000) /* limit of a voltage: the sum of two squares fits 32 bits */

/*
 * Voltages at the present speed, Q14 of U_b, because X·I may be up to 2·U_b. The functions below
 * take as `e` the voltage E that is left for the flux, 0…16383, Q14 of U_b too.
 */
typedef struct {
    dq_t reactance_q14; /* X = ω·L, 0…65534 */
    int32_t emf;        /* ω·φ, 0…VOLTS_END */
    int32_t reactive_d; /* X_d·I, 0…VOLTS_END */
    int32_t reactive_q; /* X_q·I, 0…VOLTS_END */
} weakening_volts_t;

void weakening_reset(weakening_t *weakening)
{
    *weakening =
        (weakening_t){.valley = FX_Q15_MAX, .check = FX_Q15_MAX}; /* the first radius replaces it */
}

bool weakening_holds(const weakening_t *weakening)
{
    return fx_unsigned(weakening->voltage ^ weakening->valley) == weakening->check;
}

/* Only the change goes into the check word, so a bit that has flipped stays visible. */
static void set_voltage(weakening_t *weakening, int32_t voltage)
{
    weakening->check ^= fx_unsigned(weakening->voltage ^ voltage);
    weakening->voltage = voltage;
}

/*
 * Tracks the lowest recent radius of the voltage circle. With the mean radius, each valley of a
 * rippling bus would cut off a part of the demand.
 */
static void find_valley(weakening_t *weakening, int32_t voltage_max)
{
    const int32_t risen = fx_approach(weakening->valley, voltage_max, RIPPLE_SHIFT);
    const int32_t valley = fx_min(risen, voltage_max);

    weakening->check ^= fx_unsigned(weakening->valley ^ valley);
    weakening->valley = valley;
}

static void forget(weakening_t *weakening)
{
    if (weakening->voltage != 0) {
        set_voltage(weakening, fx_towards(weakening->voltage, 0, REST_STEP));
    }
}

static bool is_demanding(dq_t demand, int32_t circle)
{
    const int32_t near = fx_asr(circle * NEAR, 4U);
    const int32_t square = near * near;

    return transforms_square(demand) > (uint32_t)square;
}

bool weakening_follow_bus(weakening_t *weakening, dq_t demand, int32_t voltage_max)
{
    bool near;

    find_valley(weakening, voltage_max);
    near = weakening->acts || is_demanding(demand, weakening->valley);
    if (!near) {
        forget(weakening);
    }
    return near;
}

/* Returns part / whole, Q16, at most 1; 0 if part is 0. The error is some 2^-15. */
static int32_t share_of(uint32_t part, uint32_t whole)
{
    int32_t share = (part > 0U) ? SHARE_ONE : 0;

    if (part < whole) {
        const uint32_t lift = fx_leading_zeros(whole);
        const uint32_t divisor = (whole << lift) >> 16U; /* 2^15…2^16 − 1 */

        const uint32_t quotient = (part << lift) / divisor;

        share = fx_min((int32_t)quotient, SHARE_ONE);
    }
    return share;
}

static int32_t part_of(int32_t share_q16, int32_t whole)
{
    return fx_asr(fx_asr(share_q16, 1U) * whole, 15U);
}

/*
 * Returns by how many bits the largest of several numbers exceeds 15 bits. all_bits: their OR.
 * Without these bits a product fits 32 bits; a 64-bit product is a library call on a Cortex-M0+.
 */
static uint32_t bits_beyond_15(uint32_t all_bits)
{
    const uint32_t zeros = fx_leading_zeros(all_bits | 1U);

    return (zeros < 17U) ? (17U - zeros) : 0U;
}

/* Returns X·i, Q14 of U_b, saturated. */
static int32_t reactive_volts(int32_t reactance_q14, int32_t current)
{
    return fx_clamp(fx_asr(reactance_q14 * current, 15U), -VOLTS_END, VOLTS_END);
}

/* Returns the voltage that the resistance takes along the demand, Q15 of U_b. */
static int32_t resistive_volts(const weakening_in_t *in, dq_t current, int32_t length)
{
    const int32_t power =
        fx_asr(current.d * in->voltage.d, 1U) + fx_asr(current.q * in->voltage.q, 1U); /* Q29 */
    const int32_t along = power / fx_max(length, 1);                                   /* Q14 */

    return fx_asr(fx_clamp(along, -CURRENT_END, CURRENT_END) * in->model->resistance_q13, 12U);
}

static int32_t flux_volts(int32_t flux_q15)
{
    return fx_asr(fx_usat15(flux_q15), 1U);
}

static weakening_volts_t volts_of(const weakening_in_t *in)
{
    const current_loop_cfg_t *const model = in->model;
    weakening_volts_t volts;

    volts.reactance_q14 = (dq_t){.d = fx_asr(in->speed_q15 * model->reactance_d_q13, 14U),
                                 .q = fx_asr(in->speed_q15 * model->reactance_q_q13, 14U)};
    volts.emf = fx_min(fx_asr(in->speed_q15 * model->emf_q13, 14U), VOLTS_END);
    volts.reactive_d = reactive_volts(volts.reactance_q14.d, in->current_max);
    volts.reactive_q = reactive_volts(volts.reactance_q14.q, in->current_max);
    return volts;
}

/* Returns √(whole² − part²), 0 if |part| > |whole|. Both ±32768. */
static int32_t other_leg(int32_t whole, int32_t part)
{
    const int32_t rest = fx_max((whole * whole) - (part * part), 0);

    return (int32_t)trig_sqrt((uint32_t)rest);
}

/* Returns the current volts / X, at most I. reactive: X·I. */
static int32_t current_of_volts(int32_t volts, int32_t reactive, int32_t current_max)
{
    return part_of(share_of((uint32_t)volts, (uint32_t)reactive), current_max);
}

/*
 * Returns the i_d at which the voltage ellipse has the i_q of the reference. Of the two solutions
 * it is the more positive one.
 */
static int32_t ellipse_d(const weakening_in_t *in, const weakening_volts_t *volts, int32_t e)
{
    const int32_t across = reactive_volts(volts->reactance_q14.q, in->reference.q);
    const int32_t left = other_leg(e, across) - volts->emf;
    const int32_t size = current_of_volts(fx_abs(left), volts->reactive_d, in->current_max);

    return (left < 0) ? -size : size;
}

/* Returns the |i_q| that the voltage ellipse has at this i_d. */
static int32_t ellipse_q(const weakening_in_t *in, const weakening_volts_t *volts, int32_t e,
                         int32_t current_d)
{
    const int32_t along = volts->emf + reactive_volts(volts->reactance_q14.d, current_d);

    return current_of_volts(other_leg(e, along), volts->reactive_q, in->current_max);
}

/*
 * Returns the i_d at which the circle of the current meets the voltage ellipse; 0 if at i_d = 0 the
 * circle lies within the ellipse.
 */
static int32_t circle_d(const weakening_in_t *in, const weakening_volts_t *volts, int32_t e)
{
    const int32_t d2 = volts->reactive_d * volts->reactive_d;
    const int32_t q2 = volts->reactive_q * volts->reactive_q;
    const int32_t lacking = (volts->emf * volts->emf) + q2 - (e * e);
    const int32_t half = volts->reactive_d * volts->emf;
    int32_t depth = 0;

    if (lacking > 0) {
        const int32_t saliency2 = q2 - d2;
        const uint32_t beyond =
            bits_beyond_15((uint32_t)half | (uint32_t)lacking | (uint32_t)fx_abs(saliency2));
        const int32_t half_15 = fx_usat15(fx_asr(half, beyond));
        const int32_t lacking_15 = fx_usat15(fx_asr(lacking, beyond));
        const int32_t saliency2_15 = fx_sat16(fx_asr(saliency2, beyond));
        const int32_t square = (half_15 * half_15) + (saliency2_15 * lacking_15);
        const uint32_t root = trig_sqrt((uint32_t)fx_max(square, 0));

        depth = part_of(share_of((uint32_t)lacking_15, (uint32_t)half_15 + root), in->current_max);
    }
    return -depth;
}

/*
 * Returns the i_d with the largest torque on the ellipse, at least −I. It is −I if the centre of
 * the ellipse is not within the circle of the current.
 */
static int32_t torque_per_volt_d(const weakening_in_t *in, const weakening_volts_t *volts,
                                 int32_t e)
{
    int32_t depth = in->current_max;

    if (volts->emf < volts->reactive_d) {
        const uint32_t saliency =
            (uint32_t)fx_max(volts->reactive_q - volts->reactive_d, 0) * (uint32_t)e;
        const uint32_t emf = (uint32_t)volts->reactive_q * (uint32_t)volts->emf;
        const uint32_t beyond = bits_beyond_15(emf | (4U * saliency));
        const uint32_t saliency_13 = saliency >> beyond;
        const uint32_t emf_15 = emf >> beyond;
        const uint32_t square = (emf_15 * emf_15) + (8U * saliency_13 * saliency_13);
        const int32_t share = share_of(saliency_13, emf_15 + trig_sqrt(square));

        depth = current_of_volts(volts->emf + part_of(share, 2 * e), volts->reactive_d,
                                 in->current_max);
    }
    return -depth;
}

/*
 * Call it where the voltage decides i_d*. Limits i_d* to the depth to which it is of use, and sets
 * `reach` to the i_q that is left there. E must contain the resistive voltage of the measured
 * current. The resistive voltage of an i_q* that the voltage does not allow would leave no
 * i_q at all in one period, and all of it in the next.
 */
static void end_where_useless(const weakening_in_t *in, const weakening_volts_t *volts, int32_t e,
                              int32_t wanted, weakening_limits_t *limits)
{
    const int32_t circle = circle_d(in, volts, e);
    const int32_t deepest = fx_max(torque_per_volt_d(in, volts, e), -in->deepest);
    const int32_t useful = fx_min(deepest, wanted); /* `wanted` may be deeper than `deepest` */

    limits->lower = circle;
    if (useful > circle) {
        limits->lower = useful;
        limits->reach = ellipse_q(in, volts, e, useful);
    }
    limits->upper = fx_max(limits->upper, limits->lower);
}

/*
 * Moves the integral by a share of `left`, the voltage that the demand leaves unused. Where i_d* is
 * as deep as it is of use, a lack of voltage (left < 0) reduces the torque and not the integral.
 * But an integral above 0 still falls: otherwise E would go on containing a voltage that the bus
 * does not have.
 */
static void correct_voltage(weakening_t *weakening, const weakening_limits_t *limits, int32_t left)
{
    const bool at_end = limits->upper <= limits->lower;
    const int32_t change = fx_asr(left, INTEGRAL_SHIFT);

    if ((change > 0) || !at_end || (weakening->voltage > 0)) {
        const int32_t end = fx_asr(weakening->valley, 2U);
        const int32_t wanted = fx_clamp(weakening->voltage + change, -end, end);

        set_voltage(weakening, fx_towards(weakening->voltage, wanted, VOLTAGE_STEP));
    }
}

weakening_limits_t weakening_step(weakening_t *weakening, const weakening_in_t *in, int32_t wanted)
{
    const int32_t length = (int32_t)trig_sqrt(transforms_square(in->voltage));
    const int32_t available = weakening->valley - fx_asr(weakening->valley * RESERVE, 8U);
    const int32_t whole = available + weakening->voltage;
    const int32_t e_asked = flux_volts(whole - resistive_volts(in, in->reference, length));
    const weakening_volts_t volts = volts_of(in);
    weakening_limits_t limits = {.lower = -CURRENT_END, .reach = CURRENT_END};

    limits.upper = ellipse_d(in, &volts, e_asked);
    weakening->acts = (limits.upper < wanted) || (in->reference.d < wanted);
    if (limits.upper < wanted) {
        const int32_t e_measured = flux_volts(whole - resistive_volts(in, in->current, length));

        end_where_useless(in, &volts, e_measured, wanted, &limits);
        correct_voltage(weakening, &limits, available - length);
    } else {
        forget(weakening);
    }
    return limits;
}
