/* SPDX-License-Identifier: MIT */
#include "source_guard.h"

#include "commander.h"

#define REST_FRACTION (256)

void source_guard_heard(source_guard_t *guard, uint32_t tick)
{
    guard->heard = tick;
}

void source_guard_leave(source_guard_t *guard)
{
    guard->watching = false;
    guard->stopping = false;
}

void source_guard_commanded(source_guard_t *guard)
{
    guard->watching = true;
    guard->stopping = false;
}

bool source_guard_is_silent(const source_guard_t *guard, uint32_t tick, uint32_t ticks)
{
    return (tick - guard->heard) > ticks;
}

bool source_guard_is_slow(const app_t *app)
{
    const step_t least = app->drive.cfg->speed_loop.speed_max / REST_FRACTION;

    return fx_abs(drive_speed(&app->drive)) < least;
}

static bool run_is_asked_for(const app_t *app)
{
    return (command_mailbox_take(&app->mailbox).request & DRIVE_REQUEST_RUN) != 0U;
}

static void go_on_stopping(source_guard_t *guard, app_t *app)
{
    if (!run_is_asked_for(app)) {
        guard->stopping = false;
    } else if (source_guard_is_slow(app)) {
        commander_stop(app, guard->source);
        guard->stopping = false;
    } else {
        /* the motor still slows down */
    }
}

bool source_guard_lose(source_guard_t *guard, app_t *app, identify_t *identify, const char *why)
{
    const source_result_t result =
        source_decide(commander_source(app), guard->source, SOURCE_EVENT_LOST);
    const bool measures = identify_is_busy(identify);
    const bool runs = !measures && (result == SOURCE_RAMPS);

    identify_refuse(identify, why);
    if (runs) {
        (void)commander_set_speed(app, guard->source, 0);
    }
    commander_renew_ticket(app, 0U); /* a run that comes late must not end this stop */
    guard->stopping = runs;
    guard->watching = false;
    return measures || runs;
}

bool source_guard_step(source_guard_t *guard, app_t *app, identify_t *identify, uint32_t tick,
                       uint32_t timeout_ticks)
{
    bool begins = false;

    if (guard->stopping) {
        go_on_stopping(guard, app);
    } else if (guard->watching && (timeout_ticks != 0U) &&
               source_guard_is_silent(guard, tick, timeout_ticks)) {
        begins = source_guard_lose(guard, app, identify, source_silence(guard->source));
    } else {
        /* the source is heard, or need not be heard */
    }
    return begins;
}
