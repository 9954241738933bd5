/* SPDX-License-Identifier: MIT */
#include "console.h"

#include "box.h"
#include "commander.h"
#include "recording_about.h"
#include "status.h"

#include <stddef.h>

#define DUMPING "a dump is under way"

void console_say(console_t *console, const char *line)
{
    text_add(&console->out, line);
    text_end_line(&console->out);
}

/*
 * Adds the answer to a command. why: the reason for a refusal; NULL: the command is done. Returns
 * whether it is done.
 */
static bool answer(console_t *console, const char *why)
{
    if (why != NULL) {
        text_add(&console->out, "error: ");
    }
    console_say(console, (why == NULL) ? "ok" : why);
    return why == NULL;
}

/*
 * Whether the recording of a fault is kept: nothing else is recorded until it is dumped or given
 * up.
 */
static bool keeps_recording(const console_t *console)
{
    const recorder_t *const recorder = console->app->recorder;

    return (recorder != NULL) && recorder->held && (console->dump_phase == CONSOLE_DUMP_NONE);
}

/* Says which reset was the last one, if the binding knows it. */
static void add_reset(text_t *text, hal_reset_t reset)
{
    if (reset.reason != HAL_RESET_UNKNOWN) {
        text_add(text, ", last reset: ");
        fault_log_tell_reset(text, reset);
    }
}

/* asked: somebody wants to know it, so it has what does not change, too. */
static void show_status(console_t *console, bool asked)
{
    status_add(&console->out, console->app, console->hal, console->about);
    if (console->input != NULL) {
        text_add(&console->out, ", input: ");
        text_add(&console->out, console->input);
    }
    if (asked) {
        add_reset(&console->out, hal_reset(console->hal));
    }
    console_say(console,
                keeps_recording(console) ? ", keeps the recording of a fault: dump or record" : "");
}

static bool set_speed(console_t *console, const char *argument)
{
    const int32_t max_rpm = console->about->speed_max_rpm;
    int32_t rpm = 0;
    const bool good = text_to_number(argument, &rpm);
    bool done = false;

    if (identify_is_busy(&console->identify)) {
        done = answer(console, CONSOLE_MEASURING); /* the target in force is a word of the probe */
    } else if (good && (rpm >= -max_rpm) && (rpm <= max_rpm)) {
        (void)commander_set_speed(console->app, console->source,
                                  units_step(&console->about->rotation, rpm));
        done = answer(console, NULL);
    } else {
        text_add(&console->out, "error: speed takes a whole number of rpm, at most ");
        text_number(&console->out, max_rpm, 0U);
        console_say(console, " either way");
    }
    return done;
}

/* If the configuration was refused, T_b is 0, and only torque 0 is accepted. */
static bool set_torque(console_t *console, const char *argument)
{
    const about_t *const about = console->about;
    const drive_cfg_t *const cfg = console->app->drive.cfg;
    const int64_t base = (cfg == NULL)
                             ? 0
                             : units_torque_base(&about->rotation, about->current_full_scale_ua,
                                                 about->bus_full_scale_uv, cfg->speed_shift);
    const int32_t most = units_torque(base, commander_torque_max(console->app));
    int32_t torque = 0;
    const bool good = text_to_millionths(argument, &torque);
    bool done = false;

    if (identify_is_busy(&console->identify)) {
        done = answer(console, CONSOLE_MEASURING);
    } else if (good && (torque >= -most) && (torque <= most)) {
        (void)commander_set_torque(console->app, console->source, units_torque_q28(base, torque));
        done = answer(console, NULL);
    } else {
        text_add(&console->out, "error: torque takes N m, at most ");
        text_number(&console->out, most, 6U);
        console_say(console, " either way");
    }
    return done;
}

/* Returns why the recorder cannot take a command now; NULL: it can. */
static const char *why_not(const console_t *console)
{
    const char *why = NULL;

    if (console->dump_phase != CONSOLE_DUMP_NONE) {
        why = DUMPING;
    } else if (console->app->recorder == NULL) {
        why = "there is no recorder";
    } else {
        /* the recorder is free */
    }
    return why;
}

/* Whether a dump would wait for ever: a tick has to freeze the recording, and no tick runs. */
static bool never_freezes(const console_t *console)
{
    const hal_t *const hal = console->hal;

    return !console->app->recorder->frozen && (hal_health(hal).tick_lost || (hal_ticks(hal) == 0U));
}

/*
 * Asks for a dump. The recorder freezes in the next ticks, unless a fault has frozen it already.
 * Returns NULL, or the reason for a refusal.
 */
static const char *ask_for_dump(console_t *console)
{
    app_t *const app = console->app;
    const char *why = why_not(console);

    if (why != NULL) {
        /* refused: `why` is the reason */
    } else if (identify_is_busy(&console->identify)) {
        /* the identification would wait for the dump's end, with current in the motor */
        why = CONSOLE_MEASURING;
    } else if (never_freezes(console)) {
        why = "the control tick does not run, nothing is recorded";
    } else {
        recorder_hold(app->recorder, &app->drive);
        console->dump_phase = CONSOLE_DUMP_ASKED;
    }
    return why;
}

/*
 * Gives up the recording of a fault, so that a new one begins. If no recording is kept, recording
 * goes on. Returns NULL, or the reason for a refusal.
 */
static const char *record_anew(console_t *console)
{
    const char *const why = why_not(console);

    if (why == NULL) {
        recorder_release(console->app->recorder);
    }
    return why;
}

static void start_dump(console_t *console)
{
    const recorder_about_t about = recording_about(console->about, hal_reset(console->hal));

    recorder_dump_start(&console->dump, console->app->recorder, &about);
    console->dump_phase = CONSOLE_DUMP_SENT;
}

/*
 * Adds the next line of the dump, or ends the dump after its last line. Each line waits until `out`
 * is sent, so other lines may come between the lines of a dump.
 */
static void send_dump(console_t *console)
{
    char line[RECORDER_LINE_CHARACTERS + 1U];

    if (recorder_dump_line(&console->dump, line)) {
        console_say(console, line);
    } else {
        recorder_release(console->app->recorder);
        console->dump_phase = CONSOLE_DUMP_NONE;
        console_say(console, "dump ends");
    }
}

/*
 * Asks for the lines of `phase` of the black box. something: there are such lines. Returns NULL, or
 * the reason for a refusal.
 */
static const char *ask_for_lines(console_t *console, console_dump_t phase, bool something)
{
    const char *why = NULL;

    if (console->dump_phase != CONSOLE_DUMP_NONE) {
        why = DUMPING;
    } else if (!something) {
        why = "there is none";
    } else {
        console->line_sent = 0U;
        console->dump_phase = phase;
    }
    return why;
}

static const char *ask_for_last(console_t *console)
{
    const box_t *const box = console->app->box;

    return ask_for_lines(console, CONSOLE_LAST_SENT, (box != NULL) && (box->file_words > 0U));
}

static const char *ask_for_faults(console_t *console)
{
    const box_t *const box = console->app->box;

    return ask_for_lines(console, CONSOLE_FAULTS_SENT,
                         (box != NULL) && (fault_log_size(box->log) > 0U));
}

/* Adds the next line of the saved recording, as send_dump(). */
static void send_last(console_t *console)
{
    const box_t *const box = console->app->box;

    if (console->line_sent < recorder_lines(box->file_words)) {
        uint32_t words[RECORDER_LINE_WORDS];
        char line[RECORDER_LINE_CHARACTERS + 1U];

        for (uint32_t k = 0U; k < RECORDER_LINE_WORDS; k++) {
            words[k] = box_word(box, (console->line_sent * RECORDER_LINE_WORDS) + k);
        }
        recorder_line(console->line_sent, words, line);
        console_say(console, line);
        console->line_sent++;
    } else {
        console->dump_phase = CONSOLE_DUMP_NONE;
        console_say(console, "dump ends");
    }
}

/* Adds the next line of the log, the oldest first. */
static void send_faults(console_t *console)
{
    const box_t *const box = console->app->box;
    const uint32_t size = fault_log_size(box->log);

    if (console->line_sent < size) {
        box_tell_entry(&console->out, box, (size - 1U) - console->line_sent);
        console_say(console, "");
        console->line_sent++;
    } else {
        console->dump_phase = CONSOLE_DUMP_NONE;
    }
}

static void send_line(console_t *console)
{
    switch (console->dump_phase) {
    case CONSOLE_DUMP_SENT:
        send_dump(console);
        break;
    case CONSOLE_LAST_SENT:
        send_last(console);
        break;
    case CONSOLE_FAULTS_SENT:
        send_faults(console);
        break;
    default: /* NONE, ASKED */
        break;
    }
}

static void go_on_dumping(console_t *console)
{
    if ((console->dump_phase == CONSOLE_DUMP_ASKED) && console->app->recorder->frozen) {
        start_dump(console);
    }
    if (console->out.length == 0U) {
        send_line(console);
    }
}

static bool same(const char *line, const char *command)
{
    const char *const rest = text_after(line, command);

    return (rest != NULL) && (rest[0] == '\0');
}

static const char *run(console_t *console)
{
    return identify_is_busy(&console->identify) ? CONSOLE_MEASURING
                                                : commander_run(console->app, console->source);
}

static const char *zero(console_t *console)
{
    return identify_is_busy(&console->identify) ? CONSOLE_MEASURING
                                                : commander_zero(console->app, console->source);
}

static const char *identify(console_t *console)
{
    const char *why = DUMPING;

    if (console->dump_phase == CONSOLE_DUMP_NONE) {
        why = identify_start(&console->identify);
    }
    if (why == NULL) {
        commander_measures(console->app, console->source);
    }
    return why;
}

static void stop(console_t *console)
{
    identify_stop(&console->identify);
    commander_stop(console->app, console->source);
}

static void do_other_line(console_t *console)
{
    const char *const line = console->line;

    if (same(line, "status")) {
        show_status(console, true);
    } else if (same(line, "dump")) {
        (void)answer(console, ask_for_dump(console));
    } else if (same(line, "record")) {
        (void)answer(console, record_anew(console));
    } else if (same(line, "last")) {
        (void)answer(console, ask_for_last(console));
    } else if (same(line, "faults")) {
        (void)answer(console, ask_for_faults(console));
    } else if (same(line, "unlock")) {
        (void)answer(console, commander_unlock(console->app));
    } else {
        (void)answer(
            console,
            "the commands are run, stop, clear, speed RPM, torque NM, zero, unlock, status, dump, record, last, faults, identify");
    }
}

/*
 * Whether a line changes the command to the drive. `stop` is left out, because it is always carried
 * out.
 */
static bool is_command(const char *line)
{
    return (text_after(line, "speed ") != NULL) || (text_after(line, "torque ") != NULL) ||
           same(line, "run") || same(line, "clear") || same(line, "zero") ||
           same(line, "identify") || same(line, "unlock");
}

/* Carries out the line. Returns whether the line commands the drive and was not refused. */
static bool do_line(console_t *console, bool counts)
{
    const char *const line = console->line;
    const char *const speed = text_after(line, "speed ");
    const char *const torque = text_after(line, "torque ");
    bool commands = false;

    if (!counts && is_command(line)) {
        commands = answer(console, COMMANDER_STALE);
    } else if (speed != NULL) {
        commands = set_speed(console, speed);
    } else if (torque != NULL) {
        commands = set_torque(console, torque);
    } else if (same(line, "run")) {
        commands = answer(console, run(console));
    } else if (same(line, "stop")) {
        stop(console);
        commands = answer(console, NULL);
    } else if (same(line, "clear")) {
        commands = answer(console, commander_clear(console->app, console->source));
    } else if (same(line, "zero")) {
        commands = answer(console, zero(console));
    } else if (same(line, "identify")) {
        commands = answer(console, identify(console));
    } else {
        do_other_line(console);
    }
    return commands;
}

bool console_take(console_t *console, uint8_t byte, bool counts)
{
    const bool ends = (byte == (uint8_t)'\r') || (byte == (uint8_t)'\n');
    bool commands = false;

    if (ends && (console->length > 0U)) {
        console->line[console->length] = '\0';
        console->length = 0U;
        commands = do_line(console, counts);
    } else if (ends) {
        /* nothing was typed */
    } else if (console->length < CONSOLE_LINE_MAX) {
        console->line[console->length] = (char)byte;
        console->length++;
    } else {
        console->line[0] = '?'; /* the line is too long: no command begins with "?" */
    }
    return commands;
}

void console_forget(console_t *console)
{
    console->length = 0U;
}

static void announce(console_t *console)
{
    const drive_state_t state = console->app->drive.state;

    if (state != console->announced) {
        console->announced = state;
        show_status(console, false);
    }
}

void console_init(console_t *console, app_t *app, hal_t *hal, const about_t *about)
{
    *console = (console_t){.app = app,
                           .hal = hal,
                           .about = about,
                           .source = SOURCE_CONSOLE,
                           .announced = DRIVE_STATE_INIT};
    identify_init(&console->identify, app, about);
}

void console_step(console_t *console)
{
    announce(console);
    go_on_dumping(console);
    identify_step(&console->identify, &console->out);
}
