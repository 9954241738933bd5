/* SPDX-License-Identifier: MIT */
/*
 * Names and advice of the faults as text: one table for simulator, console and documentation.
 *
 * Constant strings. The control step does not use them, so an image without a console does not contain them.
 * Pure, any context.
 */
#ifndef FAULT_TEXT_H
#define FAULT_TEXT_H

#include "fault.h"

/* Unit of value and limit of a fault. */
typedef enum {
    FAULT_UNIT_NONE = 0,    /* a plain number: ticks, attempts */
    FAULT_UNIT_CURRENT,     /* Q15 of I_b */
    FAULT_UNIT_VOLTAGE,     /* Q15 of U_b */
    FAULT_UNIT_SPEED,       /* step_t */
    FAULT_UNIT_HEAT,        /* Q14, 1 = steady state at the continuous current */
    FAULT_UNIT_TEMPERATURE, /* raw count of the sensor; the board file converts it to °C */
    FAULT_UNIT_WORD         /* 32 bits */
} fault_unit_t;

typedef struct {
    const char *name; /* upper case, as in fault_id_t */
    fault_unit_t unit;
    const char *advice; /* one line, ASCII: likely cause; next check */
} fault_text_t;

/* Returns the texts of a fault, those of FAULT_NONE when `id` is no fault. Never NULL. */
const fault_text_t *fault_text(fault_id_t id);

#endif
