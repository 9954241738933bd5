/* SPDX-License-Identifier: MIT */
#include "modulator.h"

#define ONE_Q12 (4096)
#define ONE_Q27 (0x8000000)
#define HALF_Q15 (0x4000)
#define HALF_SQRT3_Q15 (28378)
#define CERTAIN_SHIFT (6U) /* changes up to 1/64 of the dead time are ignored */

void modulator_reset(modulator_t *mod, const modulator_cfg_t *cfg)
{
    mod->dead_time_q15 = cfg->dead_time_q15;
    mod->inverse_bus_q12 = ONE_Q12;
}

static int32_t within_band(const modulator_cfg_t *cfg, int32_t dead_time_q15)
{
    const int32_t band = cfg->dead_time_band_q15;

    return fx_clamp(dead_time_q15, fx_max(cfg->dead_time_q15 - band, 0), cfg->dead_time_q15 + band);
}

void modulator_change(modulator_t *mod, const modulator_cfg_t *from, const modulator_cfg_t *to)
{
    const int32_t measured = mod->dead_time_q15 - from->dead_time_q15;

    mod->dead_time_q15 = within_band(to, to->dead_time_q15 + measured);
}

int32_t modulator_correct(modulator_t *mod, const modulator_cfg_t *cfg, int32_t lost)
{
    const int32_t ratio_q15 = fx_asr(lost * mod->inverse_bus_q12, 12U);
    const int32_t change = fx_asr(3 * ratio_q15, 2U);
    const int32_t before = mod->dead_time_q15;
    const int32_t certain = fx_asr(before, CERTAIN_SHIFT);

    if (fx_abs(change) > certain) {
        mod->dead_time_q15 = within_band(cfg, before + change);
    }
    return mod->dead_time_q15 - before;
}

void modulator_track_bus(modulator_t *mod, int32_t bus)
{
    const int32_t inverse = mod->inverse_bus_q12;
    /* |error| < 8 in Q12, so that the product stays below 2^31. */
    const int32_t error_q12 = fx_asr(ONE_Q27 - (inverse * bus), 15U);
    const int32_t next = inverse + fx_asr((error_q12 * inverse) + (ONE_Q12 / 2), 12U);

    mod->inverse_bus_q12 = ONE_Q12 + fx_usat15(next - ONE_Q12);
}

int32_t modulator_limit(const modulator_cfg_t *cfg, int32_t bus)
{
    return fx_asr(bus * cfg->ratio_max_q15, 15U);
}

dq_t modulator_ratio(const modulator_t *mod, dq_t voltage)
{
    return (dq_t){
        .d = fx_sat16(fx_asr(mod->inverse_bus_q12 * voltage.d, 12U)),
        .q = fx_sat16(fx_asr(mod->inverse_bus_q12 * voltage.q, 12U)),
    };
}

/* Returns the timer counts of a duty, rounded. */
static uint16_t counts(int32_t duty_q15, int32_t timer_counts)
{
    return (uint16_t)fx_asr((fx_usat15(duty_q15) * timer_counts) + HALF_Q15, 15U);
}

/* Values of the three phases. Their sum is zero. */
typedef struct {
    int32_t a;
    int32_t b;
    int32_t c;
} abc_t;

static abc_t phases(ab_t v)
{
    const int32_t half_alpha = fx_asr(v.alpha, 1U);
    const int32_t beta_part = fx_asr(v.beta * HALF_SQRT3_Q15, 15U);

    return (abc_t){v.alpha, beta_part - half_alpha, -beta_part - half_alpha};
}

/* Returns the duty that dead time and drop take from a leg whose current is above the ripple. */
static int32_t leg_loss(const modulator_t *mod, const modulator_cfg_t *cfg)
{
    return mod->dead_time_q15 + fx_asr(cfg->drop_q15 * mod->inverse_bus_q12, 12U);
}

/* Returns the duty that compensates the loss of a leg. span: largest less smallest ratio. */
static int32_t leg_compensation(const modulator_cfg_t *cfg, int32_t loss, int32_t span,
                                int32_t ratio, int32_t current)
{
    const int32_t u = fx_sat16(ratio);
    const int32_t crossing = fx_usat15(span - (9 * fx_asr(u * u, 15U)));
    const int32_t ripple = fx_asr(crossing * cfg->ripple_q15, 15U);
    const int32_t z = fx_usat15((fx_abs(current) - ripple) * cfg->edge_slope);
    const int32_t compensation = fx_asr(((2 * z) - fx_asr(z * z, 15U)) * loss, 15U);

    return (current < 0) ? -compensation : compensation;
}

static void set_compare(const modulator_cfg_t *cfg, abc_t duty, compare_t *out)
{
    const int32_t timer = cfg->timer_counts;

    out->phase[0] = counts(duty.a, timer);
    out->phase[1] = counts(duty.b, timer);
    out->phase[2] = counts(duty.c, timer);
}

/* Ratios of the three legs, and two values that the legs share. A duty is ratio + centre. */
typedef struct {
    abc_t ratio;
    int32_t centre; /* ½ less the mean of largest and smallest ratio */
    int32_t span;   /* largest less smallest ratio */
} pattern_t;

static pattern_t pattern_of(ab_t ratio)
{
    const abc_t u = phases(ratio);
    const int32_t highest = fx_max(fx_max(u.a, u.b), u.c);
    const int32_t lowest = fx_min(fx_min(u.a, u.b), u.c);

    return (pattern_t){u, HALF_Q15 - fx_asr(highest + lowest, 1U), highest - lowest};
}

void modulator_compare(const modulator_cfg_t *cfg, ab_t ratio, compare_t *out)
{
    const pattern_t p = pattern_of(ratio);
    const abc_t duty = {p.ratio.a + p.centre, p.ratio.b + p.centre, p.ratio.c + p.centre};

    set_compare(cfg, duty, out);
}

void modulator_compare_compensated(const modulator_t *mod, const modulator_cfg_t *cfg, ab_t ratio,
                                   ab_t current, compare_t *out)
{
    const pattern_t p = pattern_of(ratio);
    const int32_t loss = leg_loss(mod, cfg);
    const abc_t i = phases(current);
    const abc_t duty = {
        p.ratio.a + p.centre + leg_compensation(cfg, loss, p.span, p.ratio.a, i.a),
        p.ratio.b + p.centre + leg_compensation(cfg, loss, p.span, p.ratio.b, i.b),
        p.ratio.c + p.centre + leg_compensation(cfg, loss, p.span, p.ratio.c, i.c),
    };

    set_compare(cfg, duty, out);
}
