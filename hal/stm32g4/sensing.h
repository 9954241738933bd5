/* SPDX-License-Identifier: MIT */
/*
 * Shunt amplifiers and converters. RM0440 21.4, 25.3.
 *
 * Converters 1 and 2 start at TIM1's peak. One takes phase a first and the other phase b, so both
 * are sampled at the same time. Then the bus and, with a third sensor, phase c follow, one on each.
 * The sequence with the bus is the longer one, because the bus is sampled longest: all results are
 * ready when it ends and its interrupt comes. Temperature and throttle are regular conversions. The
 * control interrupt starts them after the injected sequences. Which converter takes what is data of
 * the board file.
 */
#ifndef SENSING_H
#define SENSING_H

#include "board.h"
#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"

#include <stdbool.h>
#include <stdint.h>

#define SENSING_COUNT_MAX (4095U)
#define SENSING_MIDDLE (2048U)

/*
 * Sets up amplifiers and converters, but not the interrupt. Measures temperature and throttle for
 * the first time, in raw counts; without a throttle `throttle` stays as it is. False when a
 * converter does not become ready.
 */
bool sensing_init(uint16_t *temperature, uint16_t *throttle);

/*
 * Enables the control interrupt: from now on the end of each sequence causes one. Earlier
 * conversions cause none.
 */
void sensing_start(void);

/*
 * Starts a conversion of the temperature sensor, or of the throttle, which takes 1.5 µs. Where one
 * converter serves both, its regular channel is set first. The other bits of the control register
 * are written as 0, which changes nothing. Context: control interrupt, right after its sequence.
 */
static inline void sensing_start_temperature(void)
{
    if (BOARD.has_throttle) {
        reg_write(HAL_ADC_TEMPERATURE + ADC_SQR1, HAL_TEMPERATURE_CHANNEL << ADC_SQR1_SQ1_SHIFT);
    }
    reg_write(HAL_ADC_TEMPERATURE + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADSTART);
}

static inline void sensing_start_throttle(void)
{
    reg_write(HAL_ADC_THROTTLE + ADC_SQR1, HAL_THROTTLE_CHANNEL << ADC_SQR1_SQ1_SHIFT);
    reg_write(HAL_ADC_THROTTLE + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADSTART);
}

/*
 * Raw counts of the regular conversion that ended last. Context: control interrupt, a tick after
 * its start or later.
 */
static inline uint16_t sensing_temperature(void)
{
    return (uint16_t)reg_read(HAL_ADC_TEMPERATURE + ADC_DR);
}

/* Whether a conversion has ended that was not read; reading clears the flag, RM0440 21.7.1. */
static inline bool sensing_has_throttle(void)
{
    return reg_any(HAL_ADC_THROTTLE + ADC_ISR, ADC_ISR_EOC);
}

static inline uint16_t sensing_throttle(void)
{
    return (uint16_t)reg_read(HAL_ADC_THROTTLE + ADC_DR);
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
