/* SPDX-License-Identifier: MIT */
#include "cross_check.h"

#include "barrier.h"
#include "instant.h"
#include "monitor.h"

#define MIDDLE_Q15 (16384) /* half of a converter's range */

/* The measurements of one tick. */
typedef struct {
    uint32_t tick;
    drive_state_t state;
    current_sum_in_t current;
    bool saturated; /* a converter is at an end of its range: its reading is not the current */
} measured_t;

static measured_t measure_tick(const app_t *app)
{
    const drive_t *const drive = &app->drive;
    const uint32_t shift = drive->cfg->sampling.current_shift;
    const uint16_t third = hal_health(app->hal).adc_ic;
    const uint32_t counts = (uint32_t)app->in.adc_ia + app->in.adc_ib + third;
    const uint32_t sum = counts << shift;
    const sample_t sample = instant_sample(drive, &app->in);

    return (measured_t){
        .tick = drive->tick,
        .state = drive->state,
        .current = {.a = sample.phase_a,
                    .b = sample.phase_b,
                    .sum = (int32_t)sum - (3 * MIDDLE_Q15)},
        .saturated = monitor_is_saturated(drive, &app->in) || protection_saturated(third, shift),
    };
}

/* Returns the length of the window in ticks. The means of the supervision have the same window. */
static uint32_t window_of(const drive_cfg_t *cfg)
{
    return (cfg->slow_ticks * SUPERVISION_STEPS) << cfg->supervision.mean_shift;
}

static fault_id_t judge_sum(app_t *app, const measured_t *measured, fault_t *fault)
{
    cross_check_t *const check = &app->check;
    const drive_cfg_t *const cfg = app->drive.cfg;
    const bool ends = (measured->tick - check->begun) >= window_of(cfg);

    if (ends || (check->sum.samples == 0U)) {
        check->begun = measured->tick;
    }
    return current_sum_step(&check->sum, &cfg->supervision, &measured->current, ends, fault);
}

static void check_sum(app_t *app, const measured_t *measured)
{
    cross_check_t *const check = &app->check;
    fault_t fault;

    fault_clear(&fault);
    if (measured->state == DRIVE_STATE_INIT) {
        current_sum_reset(&check->sum);
    } else if (measured->state == DRIVE_STATE_OFFSET_CAL) {
        if (check->state != DRIVE_STATE_OFFSET_CAL) {
            current_sum_reset(&check->sum);
        }
        current_sum_zero(&check->sum, measured->current.sum);
    } else if (!drive_is_controlled(measured->state) || measured->saturated) {
        current_sum_begin(&check->sum);
    } else if (judge_sum(app, measured, &fault) != FAULT_NONE) {
        app_fail(app, &fault);
    } else {
        /* no fault */
    }
    check->state = measured->state;
}

/*
 * If a control interrupt comes during the measurement, the values are of two ticks and are
 * discarded. The barriers make the compiler read the tick a second time.
 */
static void check_tick(app_t *app, uint32_t tick)
{
    measured_t measured;

    barrier_compiler();
    measured = measure_tick(app);
    barrier_compiler();
    if (app->drive.tick == tick) {
        app->check.tick = tick;
        check_sum(app, &measured);
    }
}

/* A board that did not start has no ticks and no configuration: nothing is checked there. */
void cross_check_step(app_t *app)
{
    const uint32_t tick = app->drive.tick;

    app_forget_failure(app);
    if (tick != app->check.tick) {
        check_tick(app, tick);
    }
}
