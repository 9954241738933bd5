/* SPDX-License-Identifier: MIT */
#include "catch_spin.h"

#include "trig.h"

#define QUARTER_TURN (0x40000000U)
#define QUARTER_TURN_BACK (0xC0000000U)

/* During a long pulse the rotor turns far enough to measure the angle. The pause must not be longer than needed. */
static uint32_t pause_ticks(const catch_spin_t *spin, const catch_spin_cfg_t *cfg)
{
    const uint32_t ticks = spin->length * cfg->gap_factor;

    return (ticks < cfg->pause_max) ? ticks : cfg->pause_max;
}

void catch_spin_reset(catch_spin_t *spin)
{
    *spin = (catch_spin_t){.phase = CATCH_SPIN_PRELOAD};
}

static void next_spin_phase(catch_spin_t *spin)
{
    spin->phase++;
    spin->tick = 0U;
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

/* The speed must explain the current within a factor of two. Wrong L and φ are within that factor, noise is not. */
static bool plausible(const catch_spin_t *spin, const catch_spin_cfg_t *cfg, int32_t current)
{
    const int32_t per_tick =
        fx_asr(fx_mul_32x16(fx_abs(spin->speed), cfg->emf_current), cfg->emf_shift);
    const int32_t expected = fx_min(per_tick, FX_Q15_MAX) * (int32_t)spin->length;

    return ((2 * current) > expected) && (current < (2 * expected));
}

static catch_spin_result_t judge(catch_spin_t *spin, const catch_spin_cfg_t *cfg, ab_t second)
{
    /*@ split spin->length; */
    const uint32_t length = spin->length;
    const int32_t least = fx_min(magnitude(spin->first), magnitude(second));
    const angle_t turned = direction(second) - direction(spin->first);
    const uint32_t between = length + pause_ticks(spin, cfg);
    const int32_t ticks = fx_max((int32_t)between, 2);
    catch_spin_result_t result = CATCH_SPIN_STANDING;

    spin->speed = fx_signed(turned) / ticks;
    if (((4 * least) > cfg->current) && plausible(spin, cfg, least)) {
        const angle_t quarter = (spin->speed > 0) ? QUARTER_TURN : QUARTER_TURN_BACK;
        const int32_t since_middle = fx_asr(spin->speed * (int32_t)length, 1U);

        spin->angle = direction(second) + quarter + fx_unsigned(since_middle);
        result = CATCH_SPIN_TURNING;
    }
    return result;
}

/* The low sides stay on, so the tick that ends the second pulse is the first tick of the charge. */
static catch_spin_result_t judge_then_charge(catch_spin_t *spin, const catch_spin_cfg_t *cfg,
                                             ab_t second)
{
    catch_spin_result_t result = judge(spin, cfg, second);

    if ((result == CATCH_SPIN_STANDING) && (cfg->charge_ticks > 0U)) {
        next_spin_phase(spin);
        result = CATCH_SPIN_BUSY;
    }
    return result;
}

/* Wait until the old current has decayed. */
static catch_spin_result_t preload(catch_spin_t *spin, const catch_spin_cfg_t *cfg, ab_t current)
{
    catch_spin_result_t result = CATCH_SPIN_BUSY;

    if (magnitude(current) <= fx_asr(cfg->current, CATCH_SPIN_QUIET_LOG2)) {
        next_spin_phase(spin);
        spin->gates = true;
    } else if (spin->tick >= cfg->wait_ticks) {
        result = CATCH_SPIN_LIVE;
    } else {
        /* it decays */
    }
    return result;
}

/* The pulse lasts until the current is large enough to measure. */
static void pulse(catch_spin_t *spin, const catch_spin_cfg_t *cfg, ab_t current)
{
    if ((magnitude(current) > cfg->current) || (spin->tick >= cfg->pulse_ticks)) {
        spin->first = current;
        spin->length = (spin->tick < cfg->pulse_ticks) ? spin->tick : cfg->pulse_ticks;
        spin->gates = false;
        next_spin_phase(spin);
    }
}

catch_spin_result_t catch_spin_step(catch_spin_t *spin, const catch_spin_cfg_t *cfg, ab_t current)
{
    catch_spin_result_t result = CATCH_SPIN_BUSY;

    spin->tick++;
    switch (spin->phase) {
    case CATCH_SPIN_PRELOAD:
        result = preload(spin, cfg, current);
        break;
    case CATCH_SPIN_FIRST_PULSE:
        pulse(spin, cfg, current);
        break;
    case CATCH_SPIN_PAUSE:
        if (spin->tick >= pause_ticks(spin, cfg)) {
            spin->gates = true;
            next_spin_phase(spin);
        }
        break;
    case CATCH_SPIN_SECOND_PULSE:
        if (spin->tick >= spin->length) {
            result = judge_then_charge(spin, cfg, current);
        }
        break;
    default: /* CATCH_SPIN_CHARGE */
        if (spin->tick >= cfg->charge_ticks) {
            result = CATCH_SPIN_STANDING;
        }
        break;
    }
    return result;
}
