/* SPDX-License-Identifier: MIT */
#include "flying_start.h"

#include "trig.h"

#define QUARTER_TURN (0x40000000U)
#define QUARTER_TURN_BACK (0xC0000000U)
/* limit of the expected current: above twice the largest measured current */
#define PULSE_CURRENT_MAX (0x1FFFF)
#define ONE_Q14 (16384)
#define WAIT_MAX (0x100000U)   /* largest wait_ticks */
#define SPEED_MAX (0x40000000) /* limit of a measured speed: a quarter of a turn in a tick */
/*
 * 1/12 of a turn. L_q is computed if the direction has turned by at least this from pulse to pulse:
 * then two directions that are off by 4° still give the speed within 20 %.
 */
#define TELLING_TURN (0x15555555U)

/*
 * Returns the ticks of the pause. After a long pulse pause_max is enough, because during such a
 * pulse the rotor already turns far enough to measure the angle.
 */
static uint32_t pause_ticks(const flying_start_t *start, const flying_start_cfg_t *cfg)
{
    const uint32_t ticks = start->length * cfg->gap_factor;

    return (ticks < cfg->pause_max) ? ticks : cfg->pause_max;
}

void flying_start_reset(flying_start_t *start)
{
    *start = (flying_start_t){.phase = FLYING_START_PRELOAD};
}

static void next_start_phase(flying_start_t *start)
{
    start->phase++;
    start->tick = 0U;
}

static angle_t direction(ab_t v)
{
    return trig_atan2((int16_t)fx_sat16(v.beta), (int16_t)fx_sat16(v.alpha));
}

static int32_t magnitude(ab_t v)
{
    const int32_t alpha = fx_sat16(v.alpha);
    const int32_t beta = fx_sat16(v.beta);
    const int32_t alpha_square = alpha * alpha;
    const int32_t beta_square = beta * beta;

    return (int32_t)trig_sqrt((uint32_t)alpha_square + (uint32_t)beta_square);
}

/*
 * Returns the current that the nominal motor has at the measured speed after a pulse. The
 * resistance takes a share of this current in each tick.
 */
static int32_t pulse_current(const flying_start_t *start, const flying_start_cfg_t *cfg)
{
    const int32_t per_tick =
        fx_asr(fx_mul_32x16(fx_abs(start->speed), cfg->emf_current), cfg->emf_shift);
    const int32_t rise = fx_min(per_tick, FX_Q15_MAX);
    int32_t current = 0;

    /*@ loop widen_hints current, 0x1FFFF; */
    for (uint32_t tick = 0U; tick < start->length; tick++) {
        current = fx_clamp(current - fx_mul_32x16(current * 2, cfg->decay_q15) + rise, 0,
                           PULSE_CURRENT_MAX);
    }
    return current;
}

/*
 * Returns L_q / configured L_q, Q14; 0: not known. A relative error of the speed gives an equal
 * relative error of L_q. So if the direction has turned only a little, the configured L_q is
 * better.
 */
static int32_t inductance_told(angle_t way, int32_t expected, int32_t current)
{
    const bool tells = (way + TELLING_TURN) >= (2U * TELLING_TURN);
    int32_t ratio_q14 = 0;

    if (tells) {
        ratio_q14 = fx_clamp((expected * ONE_Q14) / fx_max(current, 1), 1, FX_Q15_MAX);
    }
    return ratio_q14;
}

/*
 * Whether the measured current is within a factor of two of the current that is expected at the
 * measured speed. Errors of the configured L and φ stay within that factor, noise does not.
 */
static bool plausible(int32_t expected, int32_t current)
{
    return ((2 * current) > expected) && (current < (2 * expected));
}

static flying_start_result_t judge(flying_start_t *start, const flying_start_cfg_t *cfg,
                                   ab_t second)
{
    /*@ split start->length; */
    const uint32_t length = start->length;
    const int32_t one = magnitude(start->first);
    const int32_t other = magnitude(second);
    const int32_t least = fx_min(one, other);
    const angle_t turned = direction(second) - direction(start->first);
    const uint32_t between = length + pause_ticks(start, cfg);
    const int32_t ticks = fx_max((int32_t)between, 2);
    flying_start_result_t result = FLYING_START_STANDING;
    int32_t expected;

    start->speed = fx_signed(turned) / ticks;
    expected = pulse_current(start, cfg);
    if (((4 * least) > cfg->current) && plausible(expected, least)) {
        const angle_t quarter = (start->speed > 0) ? QUARTER_TURN : QUARTER_TURN_BACK;
        const int32_t since_middle = fx_asr(start->speed * (int32_t)length, 1U);

        start->angle = direction(second) + quarter + fx_unsigned(since_middle);
        start->inductance_q14 = inductance_told(turned, expected, fx_asr(one + other, 1U));
        result = FLYING_START_TURNING;
    }
    return result;
}

/*
 * Evaluates the second pulse, and begins the charge if the rotor stands. The low sides stay on, so
 * this tick is the first tick of the charge.
 */
static flying_start_result_t judge_then_charge(flying_start_t *start, const flying_start_cfg_t *cfg,
                                               ab_t second)
{
    flying_start_result_t result = judge(start, cfg, second);

    if ((result == FLYING_START_STANDING) && (cfg->charge_ticks > 0U)) {
        next_start_phase(start);
        result = FLYING_START_BUSY;
    }
    return result;
}

/*
 * Measures the speed at which a current that does not decay turns, as the mean since the first
 * tick. A rotor whose EMF is above the bus drives a turning current through the diodes. The current
 * of a stuck sensor channel does not turn.
 */
static void follow_current(flying_start_t *start, ab_t current)
{
    if (start->tick > 1U) {
        const step_t way = fx_signed(direction(current) - direction(start->first));
        const uint32_t changes = ((start->tick < WAIT_MAX) ? start->tick : WAIT_MAX) - 1U;
        const int32_t half_speed = fx_asr(start->speed, 1U);
        const int32_t half_off = (fx_asr(way, 1U) - half_speed) / (int32_t)changes;
        const int32_t half_mean = half_speed + fx_clamp(half_off, -SPEED_MAX, SPEED_MAX);

        start->speed = 2 * fx_clamp(half_mean, -(SPEED_MAX / 2), SPEED_MAX / 2);
    }
    start->first = current;
}

/*
 * Waits until the old current has decayed, and for two ticks at least, because new compare values
 * act a tick later. With the old values the legs would switch during the pulse, and their dead time
 * would act.
 */
static flying_start_result_t preload(flying_start_t *start, const flying_start_cfg_t *cfg,
                                     ab_t current)
{
    flying_start_result_t result = FLYING_START_BUSY;

    if (magnitude(current) > fx_asr(cfg->current, FLYING_START_QUIET_LOG2)) {
        follow_current(start, current);
        result = (start->tick < cfg->wait_ticks) ? FLYING_START_BUSY : FLYING_START_LIVE;
    } else if (start->tick > 1U) {
        next_start_phase(start);
        start->gates = true;
    } else {
        /* the new compare values do not act yet */
    }
    return result;
}

/* Ends the first pulse when the current is large enough to measure, or after pulse_ticks. */
static void pulse(flying_start_t *start, const flying_start_cfg_t *cfg, ab_t current)
{
    if ((magnitude(current) > cfg->current) || (start->tick >= cfg->pulse_ticks)) {
        start->first = current;
        start->length = (start->tick < cfg->pulse_ticks) ? start->tick : cfg->pulse_ticks;
        start->gates = false;
        next_start_phase(start);
    }
}

flying_start_result_t flying_start_step(flying_start_t *start, const flying_start_cfg_t *cfg,
                                        ab_t current)
{
    flying_start_result_t result = FLYING_START_BUSY;

    start->tick++;
    switch (start->phase) {
    case FLYING_START_PRELOAD:
        result = preload(start, cfg, current);
        break;
    case FLYING_START_FIRST_PULSE:
        pulse(start, cfg, current);
        break;
    case FLYING_START_PAUSE:
        if (start->tick >= pause_ticks(start, cfg)) {
            start->gates = true;
            next_start_phase(start);
        }
        break;
    case FLYING_START_SECOND_PULSE:
        if (start->tick >= start->length) {
            result = judge_then_charge(start, cfg, current);
        }
        break;
    default: /* FLYING_START_CHARGE */
        if (start->tick >= cfg->charge_ticks) {
            result = FLYING_START_STANDING;
        }
        break;
    }
    return result;
}
