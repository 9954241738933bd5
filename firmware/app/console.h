/* SPDX-License-Identifier: MIT */
/*
 * The console: one command a line, one line as answer; and the status when the drive changes its
 * state.
 *
 *     run  stop  clear  speed RPM  torque NM  zero  unlock  status  dump  record  identify
 *
 * The caller passes in the typed bytes; the console writes its text to `out`. link.h owns the line.
 * The console runs in the background, commands the drive through commander.h and reads the drive's
 * state; the control tick may interrupt it at any instruction.
 */
#ifndef CONSOLE_H
#define CONSOLE_H

#include "about.h"
#include "app.h"
#include "identify.h"
#include "recorder_dump.h"
#include "text.h"

#include <stdbool.h>
#include <stdint.h>

#define CONSOLE_LINE_MAX (31U)
#define CONSOLE_MEASURING "the motor is being measured; stop ends that"

typedef enum {
    CONSOLE_DUMP_NONE = 0,
    CONSOLE_DUMP_ASKED, /* the recording is held, and will be frozen */
    CONSOLE_DUMP_SENT   /* it is sent line by line */
} console_dump_t;

typedef struct {
    app_t *app; /* without a recorder, dump and record are refused */
    hal_t *hal;
    const about_t *about;
    drive_state_t announced;
    char line[CONSOLE_LINE_MAX + 1U];
    uint32_t length; /* of the line so far */
    text_t out;      /* text to be sent; the sender sets its length to 0 when all is sent */
    console_dump_t dump_phase;
    recorder_dump_t dump;
    identify_t identify;
} console_t;

/*
 * Call once. `app` may be all zero: it may be initialised later, or never if that fails. So the
 * console can say why it failed. All three must outlive the console.
 */
void console_init(console_t *console, app_t *app, hal_t *hal, const about_t *about);

/* Adds a line to `out`. Characters that do not fit there are lost. */
void console_say(console_t *console, const char *line);

/*
 * Takes a typed byte. CR, LF or both end a line, and the line is carried out at once. An empty line
 * is ignored. Returns true when the byte ended a line that commands the drive and was not refused.
 * counts: false for a line that comes late, see commander.h; then a command other than stop is
 * refused.
 */
bool console_take(console_t *console, uint8_t byte, bool counts);

/* Forgets a line that has begun. */
void console_forget(console_t *console);

/*
 * One pass of the background: an announcement, a line of a dump, a measurement of the motor. Call
 * as often as possible, once a tick or more. A line of a dump takes about 20000 instructions, and
 * waits until `out` is empty.
 */
void console_step(console_t *console);

#endif
