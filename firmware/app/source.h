/* SPDX-License-Identifier: MIT */
/*
 * Who may command the drive, and what follows when two want to: one table, source.c.
 *
 * A source is in command while a run or a measurement that it has asked for is in force; otherwise
 * no source is. The rules:
 *
 * - A stop of any source stops.
 * - Console and link take over from every source. The last command counts.
 * - The input commands only while nobody else does. It takes over from no running source.
 * - A source that is lost ramps to a stop what it commands itself, and nothing else.
 *
 * Pure functions. docs/without_a_pc.md shows the table.
 */
#ifndef SOURCE_H
#define SOURCE_H

typedef enum {
    SOURCE_NONE = 0,
    SOURCE_CONSOLE, /* a person who types */
    SOURCE_LINK,    /* a PC */
    SOURCE_INPUT,   /* throttle and button, input.h */
    SOURCES
} source_t;

typedef enum {
    SOURCE_EVENT_RUN = 0, /* asks for a run or a measurement */
    SOURCE_EVENT_TARGET,  /* another target for the run in force, or for the next one */
    SOURCE_EVENT_STOP,
    SOURCE_EVENT_CLEAR, /* of a fault */
    SOURCE_EVENT_LOST,  /* the source is not heard any more */
    SOURCE_EVENTS
} source_event_t;

typedef enum {
    SOURCE_REFUSES = 0, /* nothing changes */
    SOURCE_TAKES,       /* done; the source is in command from now on */
    SOURCE_STOPS,       /* the gates open, nobody is in command */
    SOURCE_RAMPS        /* the drive ramps to a stop */
} source_result_t;

/* in_command, of: below SOURCES; event: below SOURCE_EVENTS. An event of no source is refused. */
source_result_t source_decide(source_t in_command, source_t of, source_event_t event);

/* The name for a person: "nobody", "console", "link" or "input". */
const char *source_name(source_t source);

/* What a person reads when the source is not heard, as the beginning of a sentence. */
const char *source_silence(source_t source);

#endif
