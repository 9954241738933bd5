/* SPDX-License-Identifier: MIT */
/*
 * The console: one command a line, one line as answer; and the status when the drive changes its state.
 *
 *     run  stop  clear  speed RPM  status  dump  record
 *
 * Runs in the background. It posts commands to app_t.mailbox and reads the drive; the control tick may interrupt it at
 * any instruction.
 */
#ifndef CONSOLE_H
#define CONSOLE_H

#include "app.h"
#include "hal_g431.h"
#include "recorder_dump.h"
#include "text.h"

#include <stdint.h>

#define CONSOLE_LINE_MAX (31U)

typedef enum {
    CONSOLE_DUMP_NONE = 0,
    CONSOLE_DUMP_ASKED, /* the recording is held, and will be frozen */
    CONSOLE_DUMP_SENT   /* line by line */
} console_dump_t;

typedef struct {
    app_t *app; /* with a recorder once a dump is asked for */
    const hal_t *hal;
    drive_state_t announced;
    int32_t speed_rpm; /* asked for last */
    int32_t temperature_c;
    char line[CONSOLE_LINE_MAX + 1U];
    uint32_t length; /* of the line so far */
    text_t out;      /* to be sent */
    uint32_t sent;
    console_dump_t dump_phase;
    recorder_dump_t dump;
} console_t;

void console_init(console_t *console, app_t *app, const hal_t *hal);

/* Send a line. The console never waits: what does not fit behind what is still to be sent is lost. */
void console_say(console_t *console, const char *line);

/* One pass of the background: bytes in and out, a command, an announcement. */
void console_step(console_t *console);

/* The board's temperature, °C: what `status` shows. Whether it is too hot the drive decides by itself. */
void console_set_temperature(console_t *console, int32_t temperature_c);

#endif
