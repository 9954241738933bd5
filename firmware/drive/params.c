/* SPDX-License-Identifier: MIT */
#include "params.h"

#include <stddef.h>

#define Q27_ONE (0x8000000)
#define STEP_MAX (0x20000000)
#define SHIFT_MAX (30)
#define CURRENT_MAX (16384)
#define FADE_ZERO_MAX (65535)
#define FADE_SHIFT_MAX (16)
#define HEAT_SHIFT_MAX (27)
#define HEAT_Q14_MAX (0x100000)
#define PERIODS_MAX (1000000)
#define RANGE_MAX (65535)
#define RESIDUAL_MAX (8191)
#define TURN_QUARTER (0x40000000)
#define SOFTNESS_MAX (12288)
#define TICKS_MAX (0x100000)
#define POLE_PAIRS_MAX (50)
#define DESCENT_SHIFT_MIN (4)
#define DESCENT_SHIFT_MAX (12)
#define LIFT_MAX (14)

/* A shift or other count as the signed value that range() compares; anything above 2^31 is out of range too. */
static int32_t shift_value(uint32_t shift)
{
    return (shift > (uint32_t)INT32_MAX) ? -1 : (int32_t)shift;
}

/* `bad` when something was wrong before, else `name` when value is outside lo…hi, else NULL. */
static const char *range(const char *bad, const char *name, int32_t value, int32_t lo, int32_t hi)
{
    const char *result = bad;

    if ((bad == NULL) && ((value < lo) || (value > hi))) {
        result = name;
    }
    return result;
}

static const char *check_sampling(const char *before, const sampling_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "sampling.current_shift", shift_value(cfg->current_shift), 0, 7);
    bad = range(bad, "sampling.bus_shift", shift_value(cfg->bus_shift), 0, 7);
    bad = range(bad, "sampling.offset_log2", shift_value(cfg->offset_log2), 0, 12);
    return range(bad, "sampling.sensor_pole_pairs", shift_value(cfg->sensor_pole_pairs), 0,
                 POLE_PAIRS_MAX);
}

static const char *check_protection(const char *before, const protection_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "protection.current_max", cfg->current_max, 1, 16382);
    bad = range(bad, "protection.bus_max", cfg->bus_max, 1, FX_Q15_MAX - 1);
    bad = range(bad, "protection.bus_min", cfg->bus_min, 0, cfg->bus_max);
    return range(bad, "protection.offset_max", cfg->offset_max, 0, FX_Q15_MAX);
}

static const char *check_periods(const char *before, const char *name, uint32_t periods)
{
    return range(before, name, shift_value(periods), 0, PERIODS_MAX);
}

static const char *check_fade(const char *before, const char *name, const fade_t *fade)
{
    const char *bad = before;

    bad = range(bad, name, fade->zero, 0, FADE_ZERO_MAX);
    bad = range(bad, name, fade->gain, -FX_Q15_MAX, FX_Q15_MAX);
    return range(bad, name, shift_value(fade->shift), 0, FADE_SHIFT_MAX);
}

static const char *check_derating(const char *before, const derating_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "derating.current_max", cfg->current_max, 1, CURRENT_MAX);
    bad = range(bad, "derating.current_continuous", cfg->current_continuous, 1, cfg->current_max);
    bad = range(bad, "derating.heat_shift", shift_value(cfg->heat_shift), 0, HEAT_SHIFT_MAX);
    bad = range(bad, "derating.heat_gain", cfg->heat_gain, 1, FX_Q15_MAX);
    bad = range(bad, "derating.heat_rate", cfg->heat_rate, 0, FX_Q15_MAX);
    bad = range(bad, "derating.heat_rate_shift", shift_value(cfg->heat_rate_shift), 0, SHIFT_MAX);
    bad = range(bad, "derating.heat_max_q14", cfg->heat_max_q14, 1, HEAT_Q14_MAX);
    bad = check_fade(bad, "derating.heat", &cfg->heat);
    bad = check_fade(bad, "derating.temperature", &cfg->temperature);
    bad = check_periods(bad, "derating.temperature_periods", cfg->temperature_periods);
    bad = check_fade(bad, "derating.bus_high", &cfg->bus_high);
    bad = check_fade(bad, "derating.bus_low", &cfg->bus_low);
    bad = range(bad, "derating.regeneration_speed", cfg->regeneration_speed, 0, STEP_MAX);
    bad = range(bad, "derating.bus_current_max", cfg->bus_current_max, 0, FX_Q15_MAX);
    return range(bad, "derating.bus_regeneration_max", cfg->bus_regeneration_max, 0, FX_Q15_MAX);
}

static const char *check_supervision(const char *before, const supervision_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "supervision.phase_range_min", cfg->phase_range_min, 1, RANGE_MAX);
    bad = range(bad, "supervision.phase_zero_max", cfg->phase_zero_max, 0, CURRENT_MAX);
    bad = range(bad, "supervision.phase_speed_max", cfg->phase_speed_max, 1, TURN_QUARTER);
    bad = check_periods(bad, "supervision.swing_periods", cfg->swing_periods);
    bad = range(bad, "supervision.voltage_max", cfg->voltage_max, 1, FX_Q15_MAX);
    bad = range(bad, "supervision.follow_error_max", cfg->follow_error_max, 1, RANGE_MAX);
    bad = range(bad, "supervision.residual_max", cfg->residual_max, 1, RESIDUAL_MAX);
    bad = range(bad, "supervision.mean_shift", shift_value(cfg->mean_shift), 0, 14);
    bad = range(bad, "supervision.speed_error_max", cfg->speed_error_max, 1, TURN_QUARTER);
    bad = check_periods(bad, "supervision.speed_error_periods", cfg->speed_error_periods);
    bad = check_periods(bad, "supervision.runaway_periods", cfg->runaway_periods);
    bad = range(bad, "supervision.overspeed", cfg->overspeed, 1, TURN_QUARTER);
    bad = check_periods(bad, "supervision.overspeed_periods", cfg->overspeed_periods);
    bad = range(bad, "supervision.stall_current", cfg->stall_current, 1, CURRENT_MAX);
    bad = range(bad, "supervision.stall_speed", cfg->stall_speed, 1, STEP_MAX);
    bad = check_periods(bad, "supervision.stall_periods", cfg->stall_periods);
    bad = range(bad, "supervision.late_max", shift_value(cfg->late_max), 0, PERIODS_MAX);
    return range(bad, "supervision.late_window", shift_value(cfg->late_window), 1, PERIODS_MAX);
}

static const char *check_observer(const char *before, const nn_observer_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "observer.decay", cfg->decay, 0, FX_Q15_MAX);
    bad = range(bad, "observer.volt_gain", cfg->volt_gain, 1, FX_Q15_MAX);
    bad = range(bad, "observer.weight_shift", shift_value(cfg->weight_shift), 2, 15);
    bad = range(bad, "observer.flux_q27", cfg->flux_q27, 1, Q27_ONE - 1);
    bad = range(bad, "observer.iq_gain_q14", cfg->iq_gain_q14, 1, FX_Q15_MAX);
    bad = range(bad, "observer.saliency_q13", cfg->saliency_q13, 1, FX_Q15_MAX);
    bad = range(bad, "observer.current_shift", shift_value(cfg->current_shift), 0, 9);
    bad = range(bad, "observer.rate", cfg->rate, 0, FX_Q15_MAX);
    bad = range(bad, "observer.rate_shift", shift_value(cfg->rate_shift), 0, SHIFT_MAX);
    bad = range(bad, "observer.proportional", cfg->proportional, 0, FX_Q15_MAX);
    bad = range(bad, "observer.proportional_shift", shift_value(cfg->proportional_shift), 0,
                SHIFT_MAX);
    bad = range(bad, "observer.descent_shift", shift_value(cfg->descent_shift), DESCENT_SHIFT_MIN,
                DESCENT_SHIFT_MAX);
    bad = range(bad, "observer.momentum_q15", cfg->momentum_q15, 0, FX_Q15_MAX);
    bad = range(bad, "observer.speed_limit", cfg->speed_limit, 1, STEP_MAX);
    bad = range(bad, "observer.corner", cfg->corner, 0, Q27_ONE);
    bad = range(bad, "observer.rho_max_q13", cfg->rho_max_q13, 0, FX_Q15_MAX);
    return range(bad, "observer.rho_speed_min", cfg->rho_speed_min, 1, STEP_MAX);
}

/* The observer's speed limit must fit Q15 of Ω_b. */
static const char *check_speed_base(const char *before, const drive_cfg_t *cfg)
{
    const char *bad = range(before, "speed_shift", shift_value(cfg->speed_shift), 1, 16);

    if ((bad == NULL) && (fx_asr(cfg->observer.speed_limit, cfg->speed_shift) > FX_Q15_MAX)) {
        bad = "observer.speed_limit";
    }
    return bad;
}

/* Voltage per unit at the highest speed, for each gain of a loop's decoupling. */
static const char *check_reach(const char *before, const drive_cfg_t *cfg,
                               const current_loop_cfg_t *loop)
{
    const int32_t largest_gain =
        fx_max(fx_max(loop->reactance_d_q13, loop->reactance_q_q13), loop->emf_q13);
    const char *bad = before;

    if (bad == NULL) {
        const int32_t speed = fx_sat16(fx_asr(cfg->observer.speed_limit, cfg->speed_shift));

        bad = range(bad, "observer.speed_limit", fx_asr(speed * largest_gain, 13U), 0,
                    CURRENT_LOOP_REACH_MAX);
    }
    return bad;
}

/* A sample at an end of the converter range exceeds the limit with any offset, see protection.h. */
static const char *check_rails(const char *before, const drive_cfg_t *cfg)
{
    const char *bad = before;

    if (bad == NULL) {
        const uint32_t step = (uint32_t)1U << cfg->sampling.current_shift;
        const int32_t lsb = (int32_t)step;

        bad = range(bad, "protection.offset_max", cfg->protection.offset_max, 0,
                    CURRENT_MAX - 1 - lsb - cfg->protection.current_max);
    }
    return bad;
}

/* Fields of one part that must be within the limits of another part. */
static const char *check_agreement(const char *before, const drive_cfg_t *cfg)
{
    const char *bad = before;

    bad =
        range(bad, "speed_loop.speed_max", cfg->speed_loop.speed_max, 1, cfg->observer.speed_limit);
    return range(bad, "derating.current_max", cfg->derating.current_max, 1,
                 cfg->protection.current_max);
}

static const char *check_pi(const char *before, const char *name, const pi_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, name, cfg->kp, 0, FX_Q15_MAX);
    bad = range(bad, name, shift_value(cfg->kp_shift), 1, SHIFT_MAX);
    bad = range(bad, name, cfg->ki, 0, FX_Q15_MAX);
    return range(bad, name, shift_value(cfg->ki_shift), 1, SHIFT_MAX);
}

/* A current loop's fields by their names in drive_cfg_t. */
typedef struct {
    const char *pi_d;
    const char *pi_q;
    const char *reactance_d;
    const char *reactance_q;
    const char *emf;
    const char *resistance;
} loop_names_t;

static const char *check_loop(const char *before, const loop_names_t *names,
                              const current_loop_cfg_t *cfg)
{
    const char *bad = before;

    bad = check_pi(bad, names->pi_d, &cfg->pi_d);
    bad = check_pi(bad, names->pi_q, &cfg->pi_q);
    bad = range(bad, names->reactance_d, cfg->reactance_d_q13, 0, FX_Q15_MAX);
    bad = range(bad, names->reactance_q, cfg->reactance_q_q13, 0, FX_Q15_MAX);
    bad = range(bad, names->emf, cfg->emf_q13, 0, FX_Q15_MAX);
    return range(bad, names->resistance, cfg->resistance_q13, 0, FX_Q15_MAX);
}

static const char *check_current_loops(const char *before, const drive_cfg_t *cfg)
{
    static const loop_names_t run_names = {
        "current_loop.pi_d",
        "current_loop.pi_q",
        "current_loop.reactance_d_q13",
        "current_loop.reactance_q_q13",
        "current_loop.emf_q13",
        "current_loop.resistance_q13",
    };
    static const loop_names_t hold_names = {
        "hold_loop.pi_d",
        "hold_loop.pi_q",
        "hold_loop.reactance_d_q13",
        "hold_loop.reactance_q_q13",
        "hold_loop.emf_q13",
        "hold_loop.resistance_q13",
    };
    const char *bad = before;

    bad = check_loop(bad, &run_names, &cfg->current_loop);
    return check_loop(bad, &hold_names, &cfg->hold_loop);
}

static const char *check_speed_loop(const char *before, const speed_loop_cfg_t *cfg)
{
    const char *bad = before;

    bad = check_pi(bad, "speed_loop.pi", &cfg->pi);
    bad = range(bad, "speed_loop.ramp", cfg->ramp, 1, STEP_MAX);
    bad = range(bad, "speed_loop.speed_max", cfg->speed_max, 1, STEP_MAX);
    bad = range(bad, "speed_loop.inertia", cfg->inertia, 0, FX_Q15_MAX);
    bad = range(bad, "speed_loop.inertia_shift", shift_value(cfg->inertia_shift), 0, SHIFT_MAX);
    bad = range(bad, "speed_loop.inertia_lift", shift_value(cfg->inertia_lift), 0, LIFT_MAX);
    return range(bad, "speed_loop.error_shift", shift_value(cfg->error_shift), 1, 17);
}

static const char *check_position_loop(const char *before, const position_loop_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "position_loop.ramp", cfg->ramp, 1, STEP_MAX);
    bad = range(bad, "position_loop.speed_max", cfg->speed_max, 1, STEP_MAX);
    bad = range(bad, "position_loop.braking_inverse", cfg->braking_inverse, 0x10000, 0x20000);
    bad = range(bad, "position_loop.softness_q15", cfg->softness_q15, 0, SOFTNESS_MAX);
    bad = range(bad, "position_loop.gain", cfg->gain, 0, FX_Q15_MAX);
    bad = range(bad, "position_loop.gain_shift", shift_value(cfg->gain_shift), 0, SHIFT_MAX);
    return range(bad, "position_loop.distance_shift", shift_value(cfg->distance_shift), 8, 48);
}

static const char *check_modulator(const char *before, const modulator_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "modulator.timer_counts", cfg->timer_counts, 1, FX_Q15_MAX);
    bad = range(bad, "modulator.ratio_max_q15", cfg->ratio_max_q15, 1, 18918);
    bad = range(bad, "modulator.inverse_max_q12", cfg->inverse_max_q12, 4096, FX_Q15_MAX);
    bad = range(bad, "modulator.dead_time_q15", cfg->dead_time_q15, 0, 8192);
    bad = range(bad, "modulator.drop_q15", cfg->drop_q15, 0, 2048);
    bad = range(bad, "modulator.ripple_q15", cfg->ripple_q15, 0, CURRENT_MAX);
    return range(bad, "modulator.edge_slope", cfg->edge_slope, 1, FX_Q15_MAX);
}

static const char *check_catch_spin(const char *before, const catch_spin_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "startup.catch_spin.current", cfg->current, 1, CURRENT_MAX);
    bad = range(bad, "startup.catch_spin.wait_ticks", shift_value(cfg->wait_ticks), 1, TICKS_MAX);
    bad = range(bad, "startup.catch_spin.pulse_ticks", shift_value(cfg->pulse_ticks), 1, 16);
    bad = range(bad, "startup.catch_spin.gap_factor", shift_value(cfg->gap_factor), 1, 16);
    bad = range(bad, "startup.catch_spin.pause_max", shift_value(cfg->pause_max), 1, 256);
    bad = range(bad, "startup.catch_spin.emf_current", cfg->emf_current, 1, FX_Q15_MAX);
    bad = range(bad, "startup.catch_spin.emf_shift", shift_value(cfg->emf_shift), 0, SHIFT_MAX);
    return range(bad, "startup.catch_spin.charge_ticks", shift_value(cfg->charge_ticks), 0,
                 TICKS_MAX);
}

static const char *check_align(const char *before, const align_cfg_t *cfg, step_t speed_limit)
{
    const char *bad = before;

    bad = range(bad, "startup.align.current_high", cfg->current_high, 1, CURRENT_MAX);
    bad = range(bad, "startup.align.current_low", cfg->current_low, 0,
                fx_max(cfg->current_high, 1) - 1);
    bad = range(bad, "startup.align.slope", cfg->slope, 1, CURRENT_MAX);
    bad = range(bad, "startup.align.sweep_speed", cfg->sweep_speed, 1, speed_limit);
    bad = range(bad, "startup.align.pull_ticks", shift_value(cfg->pull_ticks), 1, TICKS_MAX);
    bad = range(bad, "startup.align.sweep_ticks", shift_value(cfg->sweep_ticks), 1,
                shift_value(cfg->pull_ticks));
    bad = range(bad, "startup.align.settle_ticks", shift_value(cfg->settle_ticks), 1, TICKS_MAX);
    bad = range(bad, "startup.align.measure_log2", shift_value(cfg->measure_log2), 6, 16);
    bad = range(bad, "startup.align.step_ticks", shift_value(cfg->step_ticks), 2, 16);
    bad = range(bad, "startup.align.step_voltage", cfg->step_voltage, 1, FX_Q15_MAX);
    bad = range(bad, "startup.align.step_fall", cfg->step_fall, 1, CURRENT_MAX);
    return range(bad, "startup.align.step_drop_q14", cfg->step_drop_q14, 0, 8192);
}

static const char *check_startup(const char *before, const startup_cfg_t *cfg, step_t speed_limit)
{
    const char *bad = range(before, "startup.current_hold", cfg->current_hold, 0, CURRENT_MAX);

    /* RUN reads it without a start-up too. */
    bad = range(bad, "startup.handover_speed", cfg->handover_speed, 0, STEP_MAX);
    /* Without a start-up nothing reads the next two. The proof cannot see that, so their range is checked in any case. */
    bad = range(bad, "startup.current_move", cfg->current_move, 0, CURRENT_MAX);
    bad = range(bad, "startup.current_slope", cfg->current_slope, 0, CURRENT_MAX);
    if (cfg->current_hold != 0) {
        bad = check_catch_spin(bad, &cfg->catch_spin);
        bad = check_align(bad, &cfg->align, speed_limit);
        bad = range(bad, "startup.current_move", cfg->current_move, cfg->current_hold, CURRENT_MAX);
        bad = range(bad, "startup.current_slope", cfg->current_slope, 1, CURRENT_MAX);
        bad = range(bad, "startup.ramp", cfg->ramp, 1, STEP_MAX);
        bad = range(bad, "startup.handover_speed", cfg->handover_speed, 1, STEP_MAX);
        bad = range(bad, "startup.track_speed", cfg->track_speed, 1, cfg->handover_speed);
        bad = range(bad, "startup.hold_speed", cfg->hold_speed, 1,
                    fx_max(cfg->handover_speed, 1) - 1);
        bad = range(bad, "startup.residual_max", cfg->residual_max, 1, CURRENT_MAX);
        bad =
            range(bad, "startup.residual_lost", cfg->residual_lost, cfg->residual_max, CURRENT_MAX);
        bad = range(bad, "startup.lost_periods", shift_value(cfg->lost_periods), 1, 60000);
        bad = range(bad, "startup.handover_periods", shift_value(cfg->handover_periods), 1, 60000);
        bad = range(bad, "startup.attempts", shift_value(cfg->attempts), 1, 100);
    }
    return bad;
}

static const char *check_run(const char *before, const run_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "run.current_floor", cfg->current_floor, 0, CURRENT_MAX);
    return range(bad, "run.current_slope", cfg->current_slope, 1, CURRENT_MAX);
}

static const char *check_model(const char *before, const model_cfg_t *cfg)
{
    const char *bad = before;

    bad = range(bad, "model.resistance_limit_q14", cfg->resistance_limit_q14, 0, 15000);
    bad = range(bad, "model.inductance_limit_q14", cfg->inductance_limit_q14, 0, 8192);
    bad = range(bad, "model.flux_limit_q14", cfg->flux_limit_q14, 0, 8192);
    bad = range(bad, "model.flux_rate", cfg->flux_rate, 0, FX_Q15_MAX);
    return range(bad, "model.flux_speed_min", cfg->flux_speed_min, 0, STEP_MAX);
}

static const char *check_voltage_drive(const char *before, const voltage_drive_cfg_t *cfg)
{
    const phase_compensator_cfg_t *const comp = &cfg->compensator;
    const char *bad = before;

    bad = range(bad, "voltage_drive.enabled", shift_value(cfg->enabled), 0, 1);
    if (cfg->enabled != 0U) {
        bad = check_pi(bad, "voltage_drive.pi", &cfg->pi);
        bad = range(bad, "voltage_drive.speed_min", cfg->speed_min, 0, STEP_MAX);
        bad =
            range(bad, "voltage_drive.settle_periods", shift_value(cfg->settle_periods), 1, 10000);
        bad = range(bad, "voltage_drive.compensator.gain", comp->gain, 0, FX_Q15_MAX);
        bad = range(bad, "voltage_drive.compensator.gain_shift", shift_value(comp->gain_shift), 0,
                    15);
        bad = range(bad, "voltage_drive.compensator.lead_max", comp->lead_max, 0, TURN_QUARTER);
        bad = range(bad, "voltage_drive.compensator.brake_max", comp->brake_max, 0, TURN_QUARTER);
        bad = range(bad, "voltage_drive.compensator.current_min", comp->current_min, 1, FX_Q15_MAX);
    }
    return bad;
}

/* With a sensor there is no start-up, and the observer has the speed of the sensor, so it must not be trained. */
static const char *check_sensor(const char *before, const drive_cfg_t *cfg)
{
    const char *bad = before;

    if (cfg->sampling.sensor_pole_pairs != 0U) {
        bad = range(bad, "startup.current_hold", cfg->startup.current_hold, 0, 0);
        bad = range(bad, "observer.rate", cfg->observer.rate, 0, 0);
        bad = range(bad, "observer.proportional", cfg->observer.proportional, 0, 0);
        bad = range(bad, "observer.momentum_q15", cfg->observer.momentum_q15, 0, 0);
    }
    return bad;
}

const char *params_check(const drive_cfg_t *cfg)
{
    const char *bad = NULL;

    bad = check_sampling(bad, &cfg->sampling);
    bad = check_protection(bad, &cfg->protection);
    bad = check_derating(bad, &cfg->derating);
    bad = check_observer(bad, &cfg->observer);
    bad = check_speed_base(bad, cfg);
    bad = check_current_loops(bad, cfg);
    bad = check_speed_loop(bad, &cfg->speed_loop);
    bad = check_position_loop(bad, &cfg->position_loop);
    bad = check_supervision(bad, &cfg->supervision);
    bad = check_reach(bad, cfg, &cfg->current_loop);
    bad = check_reach(bad, cfg, &cfg->hold_loop);
    bad = check_agreement(bad, cfg);
    bad = check_rails(bad, cfg);
    bad = check_modulator(bad, &cfg->modulator);
    bad = check_startup(bad, &cfg->startup, cfg->observer.speed_limit);
    bad = check_run(bad, &cfg->run);
    bad = check_model(bad, &cfg->model);
    bad = check_voltage_drive(bad, &cfg->voltage_drive);
    bad = check_sensor(bad, cfg);
    return range(bad, "slow_ticks", shift_value(cfg->slow_ticks), 6, 100);
}
