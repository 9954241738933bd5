/* SPDX-License-Identifier: MIT */
/*
 * Shunt amplifiers and converters. RM0440 21.4, 25.3.
 *
 * Both converters start at TIM1's peak: ADC1 takes phase a, then the bus; ADC2 takes phase b, then
 * phase c. So phases a and b are sampled at the same time, before the other two. ADC1's sequence is
 * the longer one, so all four results are ready when it ends and its interrupt comes. The
 * temperature is a regular conversion of ADC1. The control interrupt starts it after the injected
 * sequence.
 */
#ifndef SENSING_H
#define SENSING_H

#include "board.h"
#include "reg.h"
#include "stm32g431.h"

#include <stdbool.h>
#include <stdint.h>

/* RM0440 table 163 and data sheet table 4: inputs of the converters. */
#define SENSING_CHANNEL_BUS (1UL)          /* ADC1, PA0 */
#define SENSING_CHANNEL_SHUNT (3UL)        /* ADC1: PA2, first amplifier; ADC2: PA6, second */
#define SENSING_CHANNEL_TEMPERATURE (5UL)  /* ADC1, PB14 */
#define SENSING_CHANNEL_AMPLIFIER_3 (18UL) /* ADC2, inside */

#define SENSING_COUNT_MAX (4095U)
#define SENSING_MIDDLE (2048U)

/*
 * Sets up amplifiers and converters, but not the interrupt. Measures a first temperature in raw
 * counts. False when a converter does not become ready.
 */
bool sensing_init(uint16_t *temperature);

/*
 * Enables the control interrupt: from now on the end of each sequence causes one. Earlier
 * conversions cause none.
 */
void sensing_start(void);

/*
 * Starts a conversion of the temperature sensor, which takes 1.5 µs. The other bits of the control
 * register are written as 0, which changes nothing. Context: control interrupt, right after its
 * sequence.
 */
static inline void sensing_start_temperature(void)
{
    reg_write(ADC1 + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADSTART);
}

/*
 * Raw counts of the conversion that ended last. Context: control interrupt, a tick after its start
 * or later.
 */
static inline uint16_t sensing_temperature(void)
{
    return (uint16_t)reg_read(ADC1 + ADC_DR);
}

/*
 * Converts raw counts of a shunt amplifier to the counts of drive_in_t: zero current at mid-scale,
 * current into the motor counts up. Clamped to 0…4095.
 */
static inline uint16_t sensing_current(uint32_t raw)
{
    const uint32_t zero = BOARD.amplifier_zero;
    const uint32_t up = BOARD.amplifier_inverts ? zero : raw;
    const uint32_t down = BOARD.amplifier_inverts ? raw : zero;
    const uint32_t lifted = up + SENSING_MIDDLE;
    const uint32_t count = (lifted > down) ? (lifted - down) : 0U;

    return (uint16_t)((count < SENSING_COUNT_MAX) ? count : SENSING_COUNT_MAX);
}

#endif
