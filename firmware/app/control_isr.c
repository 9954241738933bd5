/* SPDX-License-Identifier: MIT */
#include "app.h"

#include "barrier.h"
#include "inlining.h"

#include <stddef.h>

/* Withdraws the failure that app_fail() has posted. */
static void clear_failure(app_t *app)
{
    app->fails = false;
    barrier_compiler();
    app->failure = (drive_command_t){.request = 0U};
}

const char *app_init(app_t *app, hal_t *hal, const drive_cfg_t *cfg)
{
    hal_open_gates(hal);
    app->hal = hal;
    command_mailbox_init(&app->mailbox);
    app->in = (drive_in_t){0};
    app->out = (drive_out_t){0};
    app->recorder = NULL;
    app->shaft = NULL;
    app->ticket = 0U;
    app->upsets = 0U;
    app->source = SOURCE_NONE;
    app->failed = false;
    app->unlocked = false;
    app->keeps_heat = false;
    app->change = NULL;
    clear_failure(app);
    app->check = (cross_check_t){.tick = 0U};
    return drive_init(&app->drive, cfg);
}

void app_sense(app_t *app, shaft_decoder_t *shaft)
{
    shaft_decoder_init(shaft);
    app->shaft = shaft;
}

void app_record(app_t *app, recorder_t *recorder)
{
    app->recorder = recorder;
}

/* The barrier keeps the stores to the configuration before the store that posts it. */
void app_change(app_t *app, const drive_cfg_t *cfg)
{
    barrier_compiler();
    app->change = cfg;
}

bool app_changes(const app_t *app)
{
    const bool posted = app->change != NULL;

    barrier_compiler(); /* the caller may overwrite the old configuration only after this */
    return posted;
}

RARE static void take_change(app_t *app)
{
    const drive_cfg_t *const before = app->drive.cfg;

    drive_change(&app->drive, app->change);
    if (app->recorder != NULL) {
        recorder_change(app->recorder, before);
    }
    app->change = NULL;
}

static uint32_t half_word(int32_t number)
{
    return (uint32_t)fx_clamp(number, 0, 0xFFFF);
}

/* The barriers keep the order: the failure is written only while `fails` is false. */
void app_fail(app_t *app, const fault_t *fault)
{
    const uint32_t numbers = half_word(fault->value) | (half_word(fault->limit) << 16U);

    app->fails = false;
    barrier_compiler();
    app->failure = (drive_command_t){.target = fx_signed(numbers),
                                     .mode = (uint8_t)(DRIVE_MODE_FAULT + (uint32_t)fault->id),
                                     .request = DRIVE_REQUEST_FAIL};
    barrier_compiler();
    app->fails = true;
}

/*
 * If `fails` is true but no failure is posted, a bit has flipped by itself: `fails` is cleared too.
 */
void app_forget_failure(app_t *app)
{
    if (app->fails &&
        ((app->drive.state == DRIVE_STATE_FAULT) || (app->failure.request != DRIVE_REQUEST_FAIL))) {
        clear_failure(app);
    }
}

/*
 * Whether the background has posted a failure. Both `fails` and the request must say so: a bit that
 * flips by itself in one of them neither causes a fault nor starts the drive.
 */
static bool is_told(const app_t *app)
{
    return app->fails && (app->failure.request == DRIVE_REQUEST_FAIL);
}

/* The outputs are applied before they are recorded, because little time is left for them. */
void control_isr(app_t *app)
{
    hal_sample(app->hal, &app->in);
    if ((app->shaft != NULL) && shaft_decoder_is_on(app->shaft, &app->drive.cfg->sensor)) {
        shaft_decoder_step(app->shaft, &app->drive.cfg->sensor, app->hal, &app->in);
        if (!hall_survey_is_done(&app->shaft->survey)) {
            hall_survey_step(&app->shaft->survey, app->shaft->hall.seen,
                             rotor_position_turns_q16(&app->drive.vector.position));
        }
    }
    if (drive_reads_slow_inputs(&app->drive)) {
        app->in.command = command_mailbox_take(&app->mailbox);
        if (is_told(app)) {
            app->in.command = app->failure;
        }
        if (app->change != NULL) {
            take_change(app);
        }
    }
    drive_step(&app->drive, &app->in, &app->out);
    hal_apply(app->hal, &app->out);
    if (app->recorder != NULL) {
        recorder_step(app->recorder, &app->drive, &app->in, &app->out);
    }
}
