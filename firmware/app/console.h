/* SPDX-License-Identifier: MIT */
/*
 * The console takes one command per line and answers with one line. It also shows the status when
 * the drive changes its state.
 *
 *     run  stop  clear  speed RPM  torque NM  zero  unlock  status  dump  record  last  faults
 *     identify
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
    CONSOLE_DUMP_SENT,  /* the recording is sent line by line */
    CONSOLE_LAST_SENT,  /* the same with the recording that the black box has saved */
    CONSOLE_FAULTS_SENT /* the log of faults is sent line by line */
} console_dump_t;

typedef struct {
    app_t *app; /* without a recorder, dump and record are refused */
    hal_t *hal;
    const about_t *about;
    source_t
        source; /* whose lines they are: SOURCE_CONSOLE, or SOURCE_LINK while a PC has the line */
    const char *input;       /* input_text(), for the status; NULL: there is no input */
    drive_state_t announced; /* state of the drive that was announced last */
    char line[CONSOLE_LINE_MAX + 1U];
    uint32_t length; /* characters of the line so far */
    text_t out;      /* text to be sent; the sender sets its length to 0 when all is sent */
    console_dump_t dump_phase;
    recorder_dump_t dump;
    uint32_t line_sent; /* lines of the saved recording or of the log that were sent */
    identify_t identify;
} console_t;

/*
 * Call once. `app` may be all zero, because app_init() may follow later, or may fail. So the
 * console can say why app_init() failed. `app`, `hal` and `about` must outlive the console.
 */
void console_init(console_t *console, app_t *app, hal_t *hal, const about_t *about);

/* Adds a line to `out`. Characters that do not fit there are lost. */
void console_say(console_t *console, const char *line);

/*
 * Takes a typed byte. CR, LF or both end a line, and the line is carried out at once. An empty line
 * is ignored. Returns true when the byte ended a line that commands the drive and was not refused.
 * counts: false if the ticket of the line is old (commander.h); then a command other than stop is
 * refused.
 */
bool console_take(console_t *console, uint8_t byte, bool counts);

/* Forgets a line that has begun. */
void console_forget(console_t *console);

/*
 * One pass of the background: shows a new state, sends a line of a dump, goes on with a measurement
 * of the motor. Call as often as possible, once a tick or more. A line of a dump takes about 20000
 * instructions, and waits until `out` is empty.
 */
void console_step(console_t *console);

#endif
