/* SPDX-License-Identifier: MIT */
/*
 * Faults in words: one table for everything that talks to a person.
 *
 * Constant strings; not referenced by the control step, so an image without a console has none of it.
 * Callable from any context.
 */
#ifndef FAULT_TEXT_H
#define FAULT_TEXT_H

#include "fault.h"

/* What value and limit of a record count. */
typedef enum {
    FAULT_UNIT_NONE = 0,    /* a plain number: ticks, attempts */
    FAULT_UNIT_CURRENT,     /* Q15 of I_b */
    FAULT_UNIT_VOLTAGE,     /* Q15 of U_b */
    FAULT_UNIT_SPEED,       /* step_t */
    FAULT_UNIT_HEAT,        /* Q14 of what the continuous current makes */
    FAULT_UNIT_TEMPERATURE, /* raw count of the sensor, which the board's line turns into °C */
    FAULT_UNIT_WORD         /* 32 bits */
} fault_unit_t;

typedef struct {
    const char *name; /* upper case, as in fault_id_t */
    fault_unit_t unit;
    const char *advice; /* one line, ASCII: likely cause; next check */
} fault_text_t;

/* The texts of a fault; of FAULT_NONE for a number that is none. Never NULL. */
const fault_text_t *fault_text(fault_id_t id);

#endif
