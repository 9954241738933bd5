/* SPDX-License-Identifier: MIT */
/*
 * The values of this chip's registers while the drive works, in one table. The start writes them
 * from the table, and check.h compares the registers with it later.
 *
 * A row has an address, the bits that are compared, and their value. The start writes whole groups
 * of rows. A register that gets its value in several steps, such as those of the clock, has a row
 * that is only compared. Bits that the chip changes by itself, such as the direction of a counter,
 * are not compared.
 */
#ifndef SETTINGS_H
#define SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

/* Which step of the start writes a row. */
typedef enum {
    SETTINGS_READ_ONLY, /* no step: the row is only compared */
    SETTINGS_LEVEL,     /* the DAC of the trip level; the order matters */
    /* the PWM timer and its break sources; the outputs to the gates are not connected yet */
    SETTINGS_TIMER,
    SETTINGS_OUTPUTS, /* the timer's outputs to the gates */
    SETTINGS_AMPLIFIERS,
    SETTINGS_SEQUENCES, /* sequences of the converters */
    SETTINGS_LINE,      /* the serial line */
    SETTINGS_PULSES,    /* timer and DMA of the command pin; the order matters */
    SETTINGS_SHAFT,     /* what reads the sensor of the shaft; the order matters */
    SETTINGS_PACE,      /* the timer that measures the clock */
    SETTINGS_GUARD      /* the tick guard, and its priority */
} settings_group_t;

/* Writes the rows of a group, in the order of the table. */
void settings_write(settings_group_t group);

/* Returns the value in the row with this address; 0 if there is no such row. */
uint32_t settings_value(uint32_t address);

/* Returns the number of rows. */
uint32_t settings_count(void);

/*
 * Whether the register of a row has the value of the row; row: below settings_count(). Context:
 * background.
 */
bool settings_hold(uint32_t row);

/* Returns the register's name in the manual, such as "TIM1_BDTR". */
const char *settings_name(uint32_t row);

#endif
