/* SPDX-License-Identifier: MIT */
#include "source.h"

#include <stdint.h>

#define NO ((uint8_t)SOURCE_REFUSES)
#define TAKES ((uint8_t)SOURCE_TAKES)
#define STOPS ((uint8_t)SOURCE_STOPS)
#define RAMPS ((uint8_t)SOURCE_RAMPS)

source_result_t source_decide(source_t in_command, source_t of, source_event_t event)
{
    /* [in command][source of the event][run, target, stop, clear, lost] */
    static const uint8_t table[SOURCES][SOURCES][SOURCE_EVENTS] = {
        /* nobody is in command */
        {
            {NO, NO, NO, NO, NO},
            {TAKES, TAKES, STOPS, TAKES, NO}, /* console */
            {TAKES, TAKES, STOPS, TAKES, NO}, /* link */
            {TAKES, TAKES, STOPS, TAKES, NO}, /* input */
        },
        /* the console */
        {
            {NO, NO, NO, NO, NO},
            {TAKES, TAKES, STOPS, TAKES, RAMPS},
            {TAKES, TAKES, STOPS, TAKES, NO},
            {NO, NO, STOPS, NO, NO},
        },
        /* the link */
        {
            {NO, NO, NO, NO, NO},
            {TAKES, TAKES, STOPS, TAKES, NO},
            {TAKES, TAKES, STOPS, TAKES, RAMPS},
            {NO, NO, STOPS, NO, NO},
        },
        /* the input */
        {
            {NO, NO, NO, NO, NO},
            {TAKES, TAKES, STOPS, TAKES, NO},
            {TAKES, TAKES, STOPS, TAKES, NO},
            {TAKES, TAKES, STOPS, TAKES, RAMPS},
        },
    };

    return (source_result_t)table[in_command][of][event];
}

const char *source_name(source_t source)
{
    static const char *const names[SOURCES] = {"nobody", "console", "link", "input"};

    return names[source];
}

const char *source_silence(source_t source)
{
    static const char *const silences[SOURCES] = {"nobody is heard", "nothing is typed",
                                                  "the link is silent", "the input is silent"};

    return silences[source];
}
