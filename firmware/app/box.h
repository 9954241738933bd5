/* SPDX-License-Identifier: MIT */
/*
 * The black box: the last recording of the flight recorder and the log of faults, kept through a
 * reset and through a loss of power.
 *
 *     start       box_init(&box, ...);  box_rescue(&box, ...) if a reset has left the RAM
 *     background  box_step(&box, reader);  once a pass
 *
 * After a fault the recorder has frozen. As soon as the drive is at rest with open gates,
 * box_step() writes log and recording into the flash, a unit in each pass, so that console, link
 * and watchdog go on. When the drive leaves its rest meanwhile, the writing is given up and begins
 * anew at the next rest. When the recording is saved and the drive starts again, the recorder is
 * released so that it records the next fault.
 *
 * After a reset, box_rescue() makes a recording of the RAM (recorder_rescue.h) and saves it, if the
 * gates were on until the reset, or if it holds a fault that was not saved.
 *
 * Two places in flash take turns. Each is three slots of hal.h:
 *
 *     words 0 …             the log, fault_log_t
 *     after it              the recording, packed (recorder_pack.h); none if it has no magic number
 *     units 752…767         stamps (flash_unit.h), over all words before
 *
 * A place is whole if one of its stamps is good. The one with the higher sequence number is the
 * newest. Writing takes four steps. Power may fail in each; the right column says what a start
 * finds then:
 *
 *     1. the place that is kept gets two more stamps     old recording
 *     2. the slots of the other place are erased         old recording
 *     3. log and recording are programmed into it        old recording
 *     4. it gets its stamp                               old or new recording
 *
 * Step 1 has the reason that store.h gives: whatever an interrupted erase or programming has left
 * in the other place reads as, the kept place is the newest. So the kept place's stamps get a
 * number that is higher by 2, and the new place's stamp the number after it: a stamp that was
 * interrupted in step 4 is lower than the stamps of the next step 1. The units for stamps run out
 * after seven interrupted writings in a row; then the numbers go on without them.
 *
 * To spare the flash, BOX_SAVES_MAX writings are begun after a power-up, resets included. Later
 * recordings stay in the RAM until they are read.
 */
#ifndef BOX_H
#define BOX_H

#include "about.h"
#include "app.h"
#include "fault_log.h"
#include "live_config.h"
#include "recorder_pack.h"
#include "recorder_rescue.h"
#include "text.h"

#include <stdbool.h>
#include <stdint.h>

#define BOX_SAVES_MAX (8U)
#define BOX_PLACES (2U)

typedef enum {
    BOX_IDLE = 0,
    BOX_BEGINS,   /* looks at the recording */
    BOX_MEASURES, /* chooses how much of the recording fits */
    BOX_KEEPS,    /* step 1, see above */
    BOX_ERASES,
    BOX_WRITES,
    BOX_STAMPS
} box_phase_t;

/* What is being read meanwhile. */
typedef enum {
    BOX_UNREAD = 0,
    BOX_READS_RECORDER, /* the recording of the recorder: it is not released */
    BOX_READS_SAVED     /* the saved recording: no other takes its place, and none is released */
} box_reader_t;

typedef struct box {
    hal_t *hal;
    app_t *app;
    const about_t *about;
    fault_log_t *log;
    bool found; /* a place is whole */
    uint32_t place;
    uint32_t sequence;   /* of the newest place, wraps */
    uint32_t crc;        /* of its words */
    uint32_t file_words; /* of its recording; 0: it has none */
    /* why box_rescue() has found no recording, a constant text; NULL: it has, or was not called */
    const char *why_none;
    bool rescued;
    bool works;     /* false: the flash did not keep what was written */
    bool failed;    /* the drive was in FAULT in the last step */
    uint32_t tick;  /* of the last step */
    uint32_t ticks; /* of the second that goes on */
    box_phase_t phase;
    uint32_t at; /* slot that is erased, then unit that is programmed */
    uint32_t new_crc;
    recorder_pack_t pack;
} box_t;

/*
 * Finds the newest place, and takes the log of it if the one in `log` is not whole. `log` may hold
 * anything; it and the others must outlive the box. Sets app->box. is_power_up: the time begins at
 * 0. Without slots in flash the box has only the log. Context: background, before the control
 * interrupt is enabled. Some 300000 instructions if there are recordings.
 */
void box_init(box_t *box, app_t *app, hal_t *hal, const about_t *about, fault_log_t *log,
              bool is_power_up);

/*
 * After a reset that has left the RAM as it was: `recorder` and the blocks of `live` hold what the
 * run before has left, and `place` says where the recording lies; its other members are set here.
 * Saves the recording if it is to be saved; that takes some 0.2 s. Notes the reset. Call after
 * box_init() and before these memories are used again.
 */
void box_rescue(box_t *box, recorder_t *recorder, recorder_place_t *place,
                const live_config_t *live);

/* One pass. A fault is noted in the log whatever is being read. */
void box_step(box_t *box, box_reader_t reader);

/* Whether a recording is being written: nobody may change its configurations meanwhile. */
bool box_is_saving(const box_t *box);

/* Whether the recording that the recorder keeps is saved. */
bool box_has_saved(const box_t *box);

/*
 * Word `at` of the newest saved recording, 0 when `at` is not below box->file_words or the flash
 * cannot read it.
 */
uint32_t box_word(const box_t *box, uint32_t at);

/* Adds a line, without its end: the last reset, and what was saved at it or why nothing was. */
void box_tell_start(text_t *text, const box_t *box);

/* Adds an entry of the log as a line, without its end. */
void box_tell_entry(text_t *text, const box_t *box, uint32_t age);

#endif
