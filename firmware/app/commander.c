/* SPDX-License-Identifier: MIT */
#include "commander.h"

#include <stddef.h>

static void request(app_t *app, uint8_t what)
{
    drive_command_t command = command_mailbox_take(&app->mailbox);

    command.request = what;
    command_mailbox_post(&app->mailbox, &command);
}

const char *commander_run(app_t *app)
{
    const char *why = NULL;

    if (app->drive.state == DRIVE_STATE_FAULT) {
        why = "a fault is latched; clear it first";
    } else {
        request(app, DRIVE_REQUEST_RUN);
    }
    return why;
}

void commander_stop(app_t *app)
{
    request(app, 0U);
}

const char *commander_clear(app_t *app)
{
    const char *why = NULL;

    if (app->drive.state == DRIVE_STATE_FAULT) {
        request(app, DRIVE_REQUEST_CLEAR);
    } else {
        why = "there is no fault to clear";
    }
    return why;
}

void commander_set_speed(app_t *app, step_t speed)
{
    drive_command_t command = command_mailbox_take(&app->mailbox);

    command.target = speed;
    command_mailbox_post(&app->mailbox, &command);
}

void commander_step(app_t *app)
{
    const drive_command_t command = command_mailbox_take(&app->mailbox);

    if ((command.request == DRIVE_REQUEST_CLEAR) && (app->drive.state != DRIVE_STATE_FAULT)) {
        request(app, 0U);
    }
}
