/* SPDX-License-Identifier: MIT */
#include "commander.h"

#include <stddef.h>

#define LATCHED "a fault is latched; clear it first"
#define NO_FAULT "there is no fault to clear"
#define NO_REST "what protects is unlocked at rest only; stop the drive first"
#define NO_POSITION "the rotor is not known at rest; a start counts from its own zero"
#define RUN_FROM_ZERO (DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO)

source_t commander_source(const app_t *app)
{
    const uint32_t asked = command_mailbox_take(&app->mailbox).request;

    return ((asked & (DRIVE_REQUEST_RUN | DRIVE_REQUEST_PROBE)) != 0U) ? app->source : SOURCE_NONE;
}

void commander_upset(app_t *app)
{
    app->upsets++;
}

/*
 * Whether the source may do this now. If so, it is in command from now on: of its run, or of the
 * next one. An input that goes on with its own run does not upset itself.
 */
static bool admits(app_t *app, source_t source, source_event_t event)
{
    const source_t before = commander_source(app);
    const bool may = source_decide(before, source, event) != SOURCE_REFUSES;

    if (may) {
        app->source = source;
        if ((source != SOURCE_INPUT) || (event == SOURCE_EVENT_STOP)) {
            commander_upset(app);
        }
    }
    return may;
}

uint32_t commander_ticket(const app_t *app)
{
    return app->ticket;
}

void commander_renew_ticket(app_t *app, uint32_t salt)
{
    app->ticket += 1U + salt;
}

bool commander_take_ticket(app_t *app, uint32_t ticket)
{
    const bool counts = ticket == app->ticket;

    if (counts) {
        commander_renew_ticket(app, 0U);
    }
    return counts;
}

/*
 * Returns DRIVE_REQUEST_ZERO while the drive has not taken it, else 0. The next command must keep
 * it.
 */
static uint8_t zero_to_come(const app_t *app)
{
    return (uint8_t)(command_mailbox_take(&app->mailbox).request & DRIVE_REQUEST_ZERO);
}

static void request(app_t *app, uint8_t what)
{
    drive_command_t command = command_mailbox_take(&app->mailbox);

    command.request = (uint8_t)(what | zero_to_come(app));
    command_mailbox_post(&app->mailbox, &command);
    commander_renew_ticket(app, 0U);
}

const char *commander_run(app_t *app, source_t source)
{
    const char *why = NULL;

    if (app->drive.state == DRIVE_STATE_FAULT) {
        why = LATCHED;
    } else if (admits(app, source, SOURCE_EVENT_RUN)) {
        request(app, DRIVE_REQUEST_RUN);
    } else {
        why = COMMANDER_TAKEN;
    }
    return why;
}

void commander_stop(app_t *app, source_t source)
{
    (void)admits(app, source, SOURCE_EVENT_STOP); /* the table admits every stop */
    request(app, 0U);
}

const char *commander_clear(app_t *app, source_t source)
{
    const char *why = NULL;

    if (app->drive.state != DRIVE_STATE_FAULT) {
        why = NO_FAULT;
    } else if (admits(app, source, SOURCE_EVENT_CLEAR)) {
        request(app, DRIVE_REQUEST_CLEAR);
    } else {
        why = COMMANDER_TAKEN;
    }
    return why;
}

void commander_measures(app_t *app, source_t source)
{
    (void)admits(app, source, SOURCE_EVENT_RUN);
}

const char *commander_zero(app_t *app, source_t source)
{
    const drive_t *const drive = &app->drive;
    const char *why = NULL;

    if ((drive->cfg == NULL) || !drive_knows_rotor(drive)) {
        why = NO_POSITION;
    } else if (!admits(app, source, SOURCE_EVENT_TARGET)) {
        why = COMMANDER_TAKEN;
    } else {
        drive_command_t command = command_mailbox_take(&app->mailbox);

        command.request |= (uint8_t)DRIVE_REQUEST_ZERO;
        if (command.mode == (uint8_t)DRIVE_MODE_POSITION) {
            command.target = 0;
        }
        command_mailbox_post(&app->mailbox, &command);
    }
    return why;
}

/* Puts a target in force. Returns whether the source may. */
static bool put_target(app_t *app, source_t source, drive_mode_t mode, int32_t target)
{
    const bool may = admits(app, source, SOURCE_EVENT_TARGET);

    if (may) {
        drive_command_t command = command_mailbox_take(&app->mailbox);

        command.target = target;
        command.mode = (uint8_t)mode;
        command_mailbox_post(&app->mailbox, &command);
    }
    return may;
}

bool commander_set_speed(app_t *app, source_t source, step_t speed)
{
    return put_target(app, source, DRIVE_MODE_SPEED, speed);
}

bool commander_set_torque(app_t *app, source_t source, int32_t torque_q28)
{
    return put_target(app, source, DRIVE_MODE_TORQUE, torque_q28);
}

int32_t commander_torque_max(const app_t *app)
{
    const drive_cfg_t *const cfg = app->drive.cfg;
    int32_t most = 0;

    if (cfg != NULL) {
        most = current_reference_torque_max(&cfg->current_reference, &cfg->current_loop,
                                            cfg->derating.current_max);
    }
    return most;
}

static bool is_too_strong(const app_t *app, const drive_command_t *command)
{
    const int32_t most = commander_torque_max(app);

    return (command->mode == (uint8_t)DRIVE_MODE_TORQUE) &&
           ((command->target > most) || (command->target < -most));
}

static bool is_too_fast(const drive_command_t *command, step_t speed_max)
{
    return (command->mode == (uint8_t)DRIVE_MODE_SPEED) &&
           ((command->target > speed_max) || (command->target < -speed_max));
}

/* Returns why the target is refused in this mode; NULL: it is accepted. */
static const char *target_refused(const app_t *app, const drive_command_t *command,
                                  step_t speed_max)
{
    const char *why = NULL;

    if (command->mode > (uint8_t)DRIVE_MODE_TORQUE) {
        why = "the modes are 0, speed, 1, position, and 2, torque";
    } else if (is_too_fast(command, speed_max)) {
        why = "the speed is beyond that of the motor";
    } else if (is_too_strong(app, command)) {
        why = "the torque is beyond that of the motor";
    } else {
        /* the drive can follow it */
    }
    return why;
}

/* Returns why the request is refused now; NULL: it is accepted. */
static const char *request_refused(const app_t *app, uint8_t what, bool counts)
{
    const bool failed = app->drive.state == DRIVE_STATE_FAULT;
    const char *why = counts ? NULL : COMMANDER_STALE;

    if (what == 0U) {
        why = NULL; /* a stop is always taken */
    } else if ((what > DRIVE_REQUEST_CLEAR) && (what != RUN_FROM_ZERO)) {
        why = "the requests are 0, stop, 1, run, 2, clear, and 9, run with zero here";
    } else if (failed && (what != DRIVE_REQUEST_CLEAR)) {
        why = LATCHED;
    } else if (!failed && (what == DRIVE_REQUEST_CLEAR)) {
        why = NO_FAULT;
    } else {
        /* the request is possible now; `why` is set if its ticket is old */
    }
    return why;
}

static source_event_t event_of_request(uint8_t what)
{
    source_event_t event = SOURCE_EVENT_RUN;

    if (what == 0U) {
        event = SOURCE_EVENT_STOP;
    } else if (what == DRIVE_REQUEST_CLEAR) {
        event = SOURCE_EVENT_CLEAR;
    } else {
        /* a run, also one that begins with zero here */
    }
    return event;
}

const char *commander_command(app_t *app, const drive_command_t *command, bool counts,
                              step_t speed_max)
{
    const char *why = target_refused(app, command, speed_max);

    if (why == NULL) {
        why = request_refused(app, command->request, counts);
        if (why == NULL) {
            drive_command_t taken = *command;

            (void)admits(app, SOURCE_LINK, event_of_request(command->request));
            taken.request |= zero_to_come(app);
            command_mailbox_post(&app->mailbox, &taken);
            commander_renew_ticket(app, 0U);
        }
    } else if (command->request == 0U) {
        /* a stop is obeyed, whatever else the message says */
        commander_stop(app, SOURCE_LINK);
        why = NULL;
    } else {
        /* refused: `why` is the reason */
    }
    return why;
}

void commander_limit_speed(app_t *app, step_t speed_max)
{
    drive_command_t command = command_mailbox_take(&app->mailbox);

    if (is_too_fast(&command, speed_max)) {
        command.target = (command.target > 0) ? speed_max : -speed_max;
        command_mailbox_post(&app->mailbox, &command);
    }
}

void commander_begin_anew(app_t *app)
{
    const drive_command_t none = {.target = 0, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};

    command_mailbox_post(&app->mailbox, &none);
    commander_renew_ticket(app, 0U);
    commander_upset(app);
}

bool commander_is_at_rest(const app_t *app)
{
    const drive_state_t state = app->drive.state;
    const bool calm = (state == DRIVE_STATE_READY) || (state == DRIVE_STATE_FAULT);

    return calm && !app->out.gate_enable && (command_mailbox_take(&app->mailbox).request == 0U);
}

const char *commander_unlock(app_t *app)
{
    app->unlocked = commander_is_at_rest(app);
    return app->unlocked ? NULL : NO_REST;
}

void commander_lock(app_t *app)
{
    app->unlocked = false;
}

/*
 * Returns the requests that have to end now: run in FAULT, clear outside FAULT, and zero once the
 * input frame of the last tick had it.
 */
static uint8_t requests_over(const app_t *app)
{
    const bool failed = app->drive.state == DRIVE_STATE_FAULT;
    const uint32_t level = failed ? DRIVE_REQUEST_RUN : DRIVE_REQUEST_CLEAR;

    return (uint8_t)(level | (app->in.command.request & DRIVE_REQUEST_ZERO));
}

void commander_step(app_t *app)
{
    const bool failed = app->drive.state == DRIVE_STATE_FAULT;
    const uint8_t over = requests_over(app);
    drive_command_t command;

    command_mailbox_mend(&app->mailbox);
    command = command_mailbox_take(&app->mailbox);
    if ((command.request & over) != 0U) {
        /* the ticket stays, because the PC that cleared the fault uses it next */
        command.request &= (uint8_t)~over;
        command_mailbox_post(&app->mailbox, &command);
    }
    if (failed && !app->failed) {
        commander_renew_ticket(app, 0U);
        commander_upset(app);
    }
    app->failed = failed;
    app->unlocked = app->unlocked && commander_is_at_rest(app);
}
