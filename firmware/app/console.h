/* SPDX-License-Identifier: MIT */
/*
 * The console: one command a line, one line as answer; and the status when the drive changes its
 * state.
 *
 *     run  stop  clear  speed RPM  torque NM  zero  unlock  status  dump  record  identify
 *
 * It is given the bytes that were typed, and leaves what it says in `out`; the line is link.h's. It
 * runs in the background, commands the drive by way of commander.h and reads it; the control tick
 * may interrupt it at any instruction.
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
    CONSOLE_DUMP_SENT   /* line by line */
} console_dump_t;

typedef struct {
    app_t *app; /* with a recorder once a dump is asked for */
    hal_t *hal;
    const about_t *about;
    drive_state_t announced;
    char line[CONSOLE_LINE_MAX + 1U];
    uint32_t length; /* of the line so far */
    text_t out;      /* to be sent: who has sent all of it sets its length to 0 */
    console_dump_t dump_phase;
    recorder_dump_t dump;
    identify_t identify;
} console_t;

/*
 * Call once. `app` may be initialised later, and never if that fails: it is zero before. So the
 * console can say why. All three outlive it.
 */
void console_init(console_t *console, app_t *app, hal_t *hal, const about_t *about);

/* Says a line. What does not fit behind what is still to be sent is lost. */
void console_say(console_t *console, const char *line);

/*
 * Takes a byte that was typed. A line ends with CR, LF or both and is done at once; an empty one is
 * none. True when it ended a line that commands the drive, and was not refused. counts: false for a
 * line that comes late, see commander.h; then a command other than stop is refused.
 */
bool console_take(console_t *console, uint8_t byte, bool counts);

/* A line that was begun is forgotten. */
void console_forget(console_t *console);

/*
 * One pass of the background: an announcement, a line of a dump, a measurement of the motor. Call
 * as often as possible, once a tick or more. A line of a dump takes about 20000 instructions, and
 * waits until `out` is empty.
 */
void console_step(console_t *console);

#endif
