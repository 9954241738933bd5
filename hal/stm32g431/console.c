/* SPDX-License-Identifier: MIT */
#include "console.h"

#include "barrier.h"
#include "board.h"
#include "fault_text.h"
#include "reset.h"
#include "sensing.h"
#include "temperature.h"
#include "uart.h"
#include "units.h"

#include <stdbool.h>
#include <stddef.h>

#define Q14_ONE (16384)
#define Q15_ONE (32768)
#define HEAT_BASE (1000000U)    /* makes units_thousandths() give tenths of a per cent */
#define CURRENT_BASE_RATIO (2U) /* I_b is twice the converter's full scale */

void console_say(console_t *console, const char *line)
{
    text_add(&console->out, line);
    text_end_line(&console->out);
}

static int32_t in_rpm(step_t speed)
{
    return units_rpm(&BOARD.rotation, speed);
}

static int32_t in_mv(int32_t bus_q15)
{
    return units_thousandths(bus_q15, Q15_ONE, BOARD.bus_full_scale_uv);
}

static void add_quantity(text_t *text, const char *name, int32_t value, uint32_t decimals)
{
    text_add(text, name);
    text_number(text, value, decimals);
}

/* As measured, with the amplifier's offset: that is worth a look at the first power-up. */
static void add_current(text_t *text, const char *name, uint16_t count)
{
    const int32_t above_zero = (int32_t)count - (int32_t)SENSING_MIDDLE;
    const uint32_t full_scale_ua = BOARD.current_full_scale_ua;

    add_quantity(text, name, units_thousandths(above_zero, (int32_t)SENSING_MIDDLE, full_scale_ua),
                 3U);
}

/* Value or limit of a fault with its unit. */
static void add_measure(text_t *text, const char *name, fault_unit_t unit, int32_t value)
{
    const uint32_t current_ua = BOARD.current_full_scale_ua * CURRENT_BASE_RATIO;

    switch (unit) {
    case FAULT_UNIT_CURRENT:
        add_quantity(text, name, units_thousandths(value, Q15_ONE, current_ua), 3U);
        text_add(text, " A");
        break;
    case FAULT_UNIT_VOLTAGE:
        add_quantity(text, name, in_mv(value), 3U);
        text_add(text, " V");
        break;
    case FAULT_UNIT_SPEED:
        add_quantity(text, name, in_rpm(value), 0U);
        text_add(text, " rpm");
        break;
    case FAULT_UNIT_HEAT:
        add_quantity(text, name, units_thousandths(value, Q14_ONE, HEAT_BASE), 1U);
        text_add(text, " %");
        break;
    case FAULT_UNIT_TEMPERATURE:
        add_quantity(text, name, temperature_celsius(&BOARD.temperature, (uint16_t)value), 0U);
        text_add(text, " C");
        break;
    default: /* NONE, WORD */
        add_quantity(text, name, value, 0U);
        break;
    }
}

static void add_fault(text_t *text, const fault_t *fault)
{
    const fault_text_t *const words = fault_text(fault->id);

    text_add(text, " by ");
    text_add(text, words->name);
    add_measure(text, " ", words->unit, fault->value);
    add_measure(text, ", limit ", words->unit, fault->limit);
    text_add(text, " (");
    text_add(text, words->advice);
    text_add(text, ")");
}

/* Until it is dumped nothing else is recorded. */
static bool keeps_recording(const console_t *console)
{
    const recorder_t *const recorder = console->app->recorder;

    return (recorder != NULL) && recorder->held && (console->dump_phase == CONSOLE_DUMP_NONE);
}

static void show_status(console_t *console)
{
    static const char *const states[] = {
        "INIT", "OFFSET_CAL", "READY",    "CATCH_SPIN", "ALIGN",
        "HOLD", "IF_RAMP",    "HANDOVER", "RUN",        "FAULT",
    };
    const app_t *const app = console->app;
    const drive_t *const drive = &app->drive;
    const uint32_t load_pct = (console->hal->longest * 50U) / BOARD.timer_counts;
    const drive_state_t state = drive->state;
    text_t *const out = &console->out;

    barrier_compiler(); /* the fault is that of this state */
    text_add(out, states[state]);
    if (state == DRIVE_STATE_FAULT) {
        add_fault(out, &drive->fault);
    }
    add_quantity(out, ", speed ", in_rpm(drive_speed(drive)), 0U);
    add_quantity(out, " of ", console->speed_rpm, 0U);
    add_current(out, " rpm, phases ", app->in.adc_ia);
    add_current(out, " ", app->in.adc_ib);
    add_current(out, " ", console->hal->phase_c);
    add_quantity(out, " A, bus ", in_mv(drive->signals.bus), 3U);
    add_quantity(out, " V, ", console->temperature_c, 0U);
    add_quantity(out, " C, late ", (int32_t)console->hal->overruns, 0U);
    add_quantity(out, ", load ", (int32_t)load_pct, 0U);
    text_add(out, " %");
    if (keeps_recording(console)) {
        text_add(out, ", keeps the recording of a fault: dump or record");
    }
    console_say(console, "");
}

static void request(console_t *console, uint8_t what)
{
    command_mailbox_t *const mailbox = &console->app->mailbox;
    drive_command_t command = command_mailbox_take(mailbox);

    command.request = what;
    command_mailbox_post(mailbox, &command);
}

static void start_motor(console_t *console)
{
    if (console->app->drive.state == DRIVE_STATE_FAULT) {
        console_say(console, "error: a fault is latched; clear it first");
    } else {
        request(console, DRIVE_REQUEST_RUN);
        console_say(console, "ok");
    }
}

static void clear_fault(console_t *console)
{
    if (console->app->drive.state == DRIVE_STATE_FAULT) {
        request(console, DRIVE_REQUEST_CLEAR);
        console_say(console, "ok");
    } else {
        console_say(console, "error: there is no fault to clear");
    }
}

static void stop(console_t *console)
{
    request(console, 0U);
    console_say(console, "ok");
}

static void set_speed(console_t *console, const char *argument)
{
    command_mailbox_t *const mailbox = &console->app->mailbox;
    drive_command_t command = command_mailbox_take(mailbox);
    int32_t rpm = 0;
    const bool good = text_to_number(argument, &rpm);

    if (good && (rpm >= -BOARD.speed_max_rpm) && (rpm <= BOARD.speed_max_rpm)) {
        command.target = units_step(&BOARD.rotation, rpm);
        command_mailbox_post(mailbox, &command);
        console->speed_rpm = rpm;
        console_say(console, "ok");
    } else {
        add_quantity(&console->out, "error: speed takes a whole number of rpm, at most ",
                     BOARD.speed_max_rpm, 0U);
        console_say(console, " either way");
    }
}

/* Why the recorder has nothing to do with a command now; NULL: it has. */
static const char *why_not(const console_t *console)
{
    const char *why = NULL;

    if (console->dump_phase != CONSOLE_DUMP_NONE) {
        why = "error: a dump is under way";
    } else if (console->app->recorder == NULL) {
        why = "error: there is no recorder";
    } else {
        /* it is free */
    }
    return why;
}

/* It is the tick that freezes: without one there never would be an end. */
static bool never_freezes(const console_t *console)
{
    const hal_t *const hal = console->hal;

    return !console->app->recorder->frozen && (hal->tick_lost || (hal_ticks(hal) == 0U));
}

/* The recorder freezes in the next ticks, if it has not done so after a fault. */
static void ask_for_dump(console_t *console)
{
    app_t *const app = console->app;
    const char *const why = why_not(console);

    if (why != NULL) {
        console_say(console, why);
    } else if (never_freezes(console)) {
        console_say(console, "error: the control tick does not run, nothing is recorded");
    } else {
        recorder_hold(app->recorder, &app->drive);
        console->dump_phase = CONSOLE_DUMP_ASKED;
        console_say(console, "ok");
    }
}

/* The recording of a fault is given up; one that is not kept goes on. */
static void record_anew(console_t *console)
{
    const char *const why = why_not(console);

    if (why == NULL) {
        recorder_release(console->app->recorder);
    }
    console_say(console, (why == NULL) ? "ok" : why);
}

static void start_dump(console_t *console)
{
    const app_t *const app = console->app;
    recorder_about_t about = {
        .tick_ps = BOARD.rotation.tick_ps,
        .current_full_scale_ua = BOARD.current_full_scale_ua,
        .bus_full_scale_uv = BOARD.bus_full_scale_uv,
        .pole_pairs = BOARD.rotation.pole_pairs,
    };

    recorder_about_name(&about, BOARD_NAME);
    for (uint32_t k = 0U; k < RECORDER_BUILD_WORDS; k++) {
        about.build[k] = build_id_note[BUILD_ID_FIRST_WORD + k];
    }
    recorder_dump_start(&console->dump, app->recorder, app->drive.cfg, &about);
    console->dump_phase = CONSOLE_DUMP_SENT;
}

/* A line of the dump once all before it is sent: other lines come in between. */
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

static void go_on_dumping(console_t *console)
{
    if ((console->dump_phase == CONSOLE_DUMP_ASKED) && console->app->recorder->frozen) {
        start_dump(console);
    }
    if ((console->dump_phase == CONSOLE_DUMP_SENT) && (console->out.length == 0U)) {
        send_dump(console);
    }
}

static bool same(const char *line, const char *command)
{
    const char *const rest = text_after(line, command);

    return (rest != NULL) && (rest[0] == '\0');
}

static void do_line(console_t *console)
{
    const char *const line = console->line;
    const char *const speed = text_after(line, "speed ");

    if (speed != NULL) {
        set_speed(console, speed);
    } else if (same(line, "run")) {
        start_motor(console);
    } else if (same(line, "stop")) {
        stop(console);
    } else if (same(line, "clear")) {
        clear_fault(console);
    } else if (same(line, "status")) {
        show_status(console);
    } else if (same(line, "dump")) {
        ask_for_dump(console);
    } else if (same(line, "record")) {
        record_anew(console);
    } else {
        console_say(console,
                    "error: the commands are run, stop, clear, speed RPM, status, dump, record");
    }
}

/* A line ends with CR, LF or both; an empty one is none. */
static void take(console_t *console, uint8_t byte)
{
    const bool ends = (byte == (uint8_t)'\r') || (byte == (uint8_t)'\n');

    if (ends && (console->length > 0U)) {
        console->line[console->length] = '\0';
        console->length = 0U;
        do_line(console);
    } else if (ends) {
        /* nothing was typed */
    } else if (console->length < CONSOLE_LINE_MAX) {
        console->line[console->length] = (char)byte;
        console->length++;
    } else {
        console->line[0] = '?'; /* too long: no command starts so */
    }
}

/* A clear is done once the fault is left: kept, it would clear the next one unseen. */
static void finish_clear(console_t *console)
{
    const drive_command_t command = command_mailbox_take(&console->app->mailbox);

    if ((command.request == DRIVE_REQUEST_CLEAR) &&
        (console->app->drive.state != DRIVE_STATE_FAULT)) {
        request(console, 0U);
    }
}

static void announce(console_t *console)
{
    const drive_state_t state = console->app->drive.state;

    if (state != console->announced) {
        console->announced = state;
        show_status(console);
    }
}

static void send(console_t *console)
{
    text_t *const out = &console->out;

    while ((console->sent < out->length) && uart_put((uint8_t)out->characters[console->sent])) {
        console->sent++;
    }
    if (console->sent == out->length) {
        console->sent = 0U;
        out->length = 0U;
    }
}

void console_init(console_t *console, app_t *app, const hal_t *hal)
{
    *console = (console_t){.app = app, .hal = hal, .announced = DRIVE_STATE_INIT};
}

void console_step(console_t *console)
{
    uint8_t byte = 0U;

    while (uart_get(&byte)) {
        take(console, byte);
    }
    finish_clear(console);
    announce(console);
    go_on_dumping(console);
    send(console);
}

void console_set_temperature(console_t *console, int32_t temperature_c)
{
    console->temperature_c = temperature_c;
}
