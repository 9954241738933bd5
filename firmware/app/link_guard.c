/* SPDX-License-Identifier: MIT */
#include "link_guard.h"

#include "commander.h"

#define REST_FRACTION (256) /* below 1/256 of the highest speed the motor is at rest */

void link_guard_heard(link_guard_t *guard, uint32_t tick)
{
    guard->heard = tick;
}

void link_guard_leave(link_guard_t *guard)
{
    guard->watching = false;
    guard->stopping = false;
}

void link_guard_commanded(link_guard_t *guard)
{
    guard->watching = true;
    guard->stopping = false;
}

bool link_guard_is_silent(const link_guard_t *guard, uint32_t tick, uint32_t ticks)
{
    return (tick - guard->heard) > ticks;
}

static bool run_is_asked_for(const app_t *app)
{
    return (command_mailbox_take(&app->mailbox).request & DRIVE_REQUEST_RUN) != 0U;
}

static void go_on_stopping(link_guard_t *guard, app_t *app)
{
    const step_t least = app->drive.cfg->speed_loop.speed_max / REST_FRACTION;

    if (!run_is_asked_for(app)) {
        guard->stopping = false;
    } else if (fx_abs(drive_speed(&app->drive)) < least) {
        commander_stop(app);
        guard->stopping = false;
    } else {
        /* the motor still slows down */
    }
}

/* Begins a stop. Returns whether there was something to stop. */
static bool begin_stopping(link_guard_t *guard, app_t *app, identify_t *identify)
{
    const bool measures = identify_is_busy(identify);
    const bool runs = !measures && run_is_asked_for(app);

    identify_refuse(identify, "the link is silent");
    if (runs) {
        commander_set_speed(app, 0);
    }
    commander_renew_ticket(app, 0U); /* a run that comes late must not end this stop */
    guard->stopping = runs;
    guard->watching = false;
    return measures || runs;
}

bool link_guard_step(link_guard_t *guard, app_t *app, identify_t *identify, uint32_t tick,
                     uint32_t timeout_ticks)
{
    bool begins = false;

    if (guard->stopping) {
        go_on_stopping(guard, app);
    } else if (guard->watching && (timeout_ticks != 0U) &&
               link_guard_is_silent(guard, tick, timeout_ticks)) {
        begins = begin_stopping(guard, app, identify);
    } else {
        /* the PC is heard, or need not be heard */
    }
    return begins;
}
