/* SPDX-License-Identifier: MIT */
/*
 * What the registers of this chip hold while the drive works: one table, from which they are
 * written and against which they are read back.
 *
 * A row has an address, the bits that count, and their value. The start writes whole groups of
 * rows. A register that is brought to its value in steps, as the clock's are, has a row only to be
 * read back. Bits that the chip changes by itself, such as the direction of a counter, are not
 * among those that count.
 */
#ifndef SETTINGS_H
#define SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

/* Which step of the start writes a row. */
typedef enum {
    SETTINGS_READ_ONLY, /* none: it is only read back */
    SETTINGS_LEVEL,     /* the trip level's converters, in this order */
    /* the PWM timer, and what breaks it; the gates' outputs are not connected yet */
    SETTINGS_TIMER,
    SETTINGS_OUTPUTS, /* the timer's outputs to the gates */
    SETTINGS_AMPLIFIERS,
    SETTINGS_SEQUENCES, /* of the converters */
    SETTINGS_LINE,      /* the serial one */
    SETTINGS_PACE,      /* the timer that measures the clock */
    SETTINGS_GUARD      /* what the tick guard needs */
} settings_group_t;

/* Write the rows of a group, in the order of the table. */
void settings_write(settings_group_t group);

/* What the row of this address says. 0 for an address that has none. */
uint32_t settings_value(uint32_t address);

/* The number of rows. */
uint32_t settings_count(void);

/*
 * Whether the register of a row holds what the row says; row: below settings_count(). Context:
 * background.
 */
bool settings_hold(uint32_t row);

/* The register's name as the manual has it, such as "TIM1_BDTR". */
const char *settings_name(uint32_t row);

#endif
