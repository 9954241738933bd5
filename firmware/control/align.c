/* SPDX-License-Identifier: MIT */
#include "align.h"

#include "fx.h"

#define MEAN_BITS (6U)
/* 2^16 samples of 32767: limit of a sum before the next sample is added */
#define SUM_MAX (0x7FFF0000)
#define MEAN_MAX (64 * FX_Q15_MAX)
/*
 * A swing with a damping of 0.008 or more shrinks within two measurements to at most 15/16 of its
 * size: 15/16 = exp(-8*0.008).
 */
#define CALM_SIXTEENTHS (15)
/*
 * Formats of the extrapolation to zero current. Voltages have a resolution of 1/8 LSB. The distance
 * from the high current to zero is in Q10 of the distance between the two currents.
 */
#define LOST_BITS (3U)
#define DISTANCE_ONE_Q10 (1024)
#define DISTANCE_MAX_Q10 (4095)
#define LOST_MAX (16384)

void align_reset(align_t *align, bool backwards)
{
    *align = (align_t){.phase = ALIGN_PULL, .backwards = backwards};
}

void align_reset_held(align_t *align, const align_cfg_t *cfg, int32_t current_ref)
{
    *align = (align_t){.phase = ALIGN_PULL, .tick = cfg->sweep_ticks, .current_ref = current_ref};
}

static void next_align_phase(align_t *align)
{
    align->phase++;
    align->tick = 0U;
}

static void begin_measuring(align_t *align, const align_cfg_t *cfg)
{
    align->swing = 0;
    align->swing_bound = cfg->current_high / ALIGN_SLIP_SHARE;
    align->swing_before = align->swing_bound;
    next_align_phase(align);
}

static void pull_rotor(align_t *align, const align_cfg_t *cfg)
{
    align->current_ref = fx_towards(align->current_ref, cfg->current_high, cfg->slope);
    align->frame_speed = 0;
    if (align->tick <= cfg->sweep_ticks) {
        align->frame_speed = align->backwards ? -cfg->sweep_speed : cfg->sweep_speed;
    }
    if (align->tick >= cfg->pull_ticks) {
        begin_measuring(align, cfg);
    }
}

static int32_t added(int32_t sum, int32_t sample)
{
    return fx_clamp(sum, -SUM_MAX, SUM_MAX) + sample;
}

static bool calms_down(const align_t *align, const align_cfg_t *cfg)
{
    return (align->swing > cfg->swing_max) && (align->swing <= align->swing_bound);
}

static void measure_again(align_t *align, align_point_t *point)
{
    align->swing_bound = fx_asr(CALM_SIXTEENTHS * fx_max(align->swing, align->swing_before), 4U);
    align->swing_before = align->swing;
    align->swing = 0;
    align->tick = 0U;
    *point = (align_point_t){0, 0};
}

static void end_measuring(align_t *align, const align_cfg_t *cfg, align_point_t *point)
{
    point->current = fx_asr(point->current, cfg->measure_log2 - MEAN_BITS);
    point->voltage = fx_asr(point->voltage, cfg->measure_log2 - MEAN_BITS);
    next_align_phase(align);
}

static void measure(align_t *align, const align_cfg_t *cfg, align_point_t *point, dq_t current,
                    int32_t voltage)
{
    align->swing = fx_max(align->swing, fx_abs(current.q));
    point->current = added(point->current, current.d);
    point->voltage = added(point->voltage, voltage);
    if (align->tick < (1UL << cfg->measure_log2)) {
        /* the measurement goes on */
    } else if (calms_down(align, cfg)) {
        measure_again(align, point);
    } else {
        end_measuring(align, cfg, point);
    }
}

/* Sets the reference to current_low, without a slope, as soon as the current control resumes. */
static void measure_inductance(align_t *align, const align_cfg_t *cfg, dq_t current)
{
    if (!inductance_holds_voltage(&cfg->inductance, align->tick)) {
        align->current_ref = cfg->current_low;
    }
    if (inductance_step(&align->inductance, &cfg->inductance, align->tick, current)) {
        next_align_phase(align);
    }
}

/* Returns a finished sum, 64 times a mean, limited to the range of 64 Q15 values. */
static int32_t mean_of(int32_t sum)
{
    return fx_clamp(sum, -MEAN_MAX, MEAN_MAX);
}

static int32_t resistance_q13(const align_t *align)
{
    const int32_t voltage = mean_of(align->high.voltage) - mean_of(align->low.voltage);
    const int32_t current = fx_asr(mean_of(align->high.current) - mean_of(align->low.current), 4U);
    int32_t result = ALIGN_UNKNOWN;

    if ((current > 0) && (voltage > 0)) {
        result = fx_min((voltage * 512) / current, FX_Q15_MAX);
    }
    return result;
}

static int32_t lost_voltage(const align_t *align)
{
    const int32_t current = mean_of(align->high.current);
    const int32_t apart = current - mean_of(align->low.current);
    const int32_t voltage = mean_of(align->high.voltage);
    int32_t lost = 0;

    if ((current > 0) && (apart > 0)) {
        const int32_t change = fx_asr(voltage - mean_of(align->low.voltage), LOST_BITS);
        const int32_t distance_q10 = fx_min((current * DISTANCE_ONE_Q10) / apart, DISTANCE_MAX_Q10);
        const int32_t left = fx_asr(voltage, LOST_BITS) - fx_asr(change * distance_q10, 10U);

        lost = fx_clamp(fx_asr(left, MEAN_BITS - LOST_BITS), -LOST_MAX, LOST_MAX);
    }
    return lost;
}

static void evaluate(align_t *align, const align_cfg_t *cfg)
{
    const int32_t resistance = resistance_q13(align);

    align->found = (align_found_t){
        .resistance_q13 = resistance,
        .inductance = {ALIGN_UNKNOWN, ALIGN_UNKNOWN},
        .lost_voltage = lost_voltage(align),
    };
    if (resistance > 0) {
        align->found.inductance =
            inductance_result(&align->inductance, &cfg->inductance, resistance);
    }
    next_align_phase(align);
}

void align_step(align_t *align, const align_cfg_t *cfg, dq_t current, int32_t voltage)
{
    align->tick++;
    switch (align->phase) {
    case ALIGN_PULL:
        pull_rotor(align, cfg);
        break;
    case ALIGN_MEASURE_HIGH:
        measure(align, cfg, &align->high, current, voltage);
        break;
    case ALIGN_INDUCTANCE:
        measure_inductance(align, cfg, current);
        break;
    case ALIGN_SETTLE:
        if (align->tick >= cfg->settle_ticks) {
            begin_measuring(align, cfg);
        }
        break;
    case ALIGN_MEASURE_LOW:
        measure(align, cfg, &align->low, current, voltage);
        break;
    case ALIGN_EVALUATE:
        evaluate(align, cfg);
        break;
    default: /* DONE */
        break;
    }
}

bool align_holds_voltage(const align_t *align, const align_cfg_t *cfg)
{
    return (align->phase == ALIGN_INDUCTANCE) &&
           inductance_holds_voltage(&cfg->inductance, align->tick);
}

dq_t align_voltage(const align_t *align, const align_cfg_t *cfg)
{
    return inductance_voltage(&cfg->inductance, align->tick);
}

bool align_has_measured(const align_t *align)
{
    return (align->tick == 0U) &&
           ((align->phase == ALIGN_INDUCTANCE) || (align->phase == ALIGN_EVALUATE));
}

bool align_is_at_rest(const align_t *align, const align_cfg_t *cfg)
{
    return align->swing <= cfg->swing_max;
}
