/* SPDX-License-Identifier: MIT */
/*
 * TIM1: centre-aligned complementary PWM on three half bridges. RM0440 28.3.
 *
 * PWM mode 1: the high side is on while the counter is below the compare value, so the low side is
 * on around the counter's peak. The update event comes once a period, at the peak: it loads the
 * compare values, and as TRGO2 it starts the converters. So the currents are sampled and the
 * compare values are loaded at the same instant, the middle of the low sides' on-time.
 *
 * A driver with one input a phase makes the dead time itself, and has an enable line a phase. These
 * lines are the low outputs, switched off: off, an output has its inactive level, which the
 * polarity makes high, while the main output is on, and its idle level, low, while it is not.
 * RM0440 28.3.16, table of output control bits.
 *
 * Break. What trip.h watches clears the main output enable (MOE) without the core; then all six
 * outputs have their idle levels, at which the gates are off. A lockup of the core, a parity error
 * of the RAM and a supply below 2.8 V do the same. pwm_connect() locks dead time, break and idle
 * levels until reset.
 */
#ifndef PWM_H
#define PWM_H

#include "board.h"
#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"

#include <stdbool.h>
#include <stdint.h>

/* Flags of a break by what trip.h watches, and by the system. */
#define PWM_BREAK_FLAGS (TIM_SR_BIF | TIM_SR_SBIF)

/* Sets up the timer. Its outputs are not connected, and its counter does not run; gates open. */
void pwm_init(void);

/*
 * Connects the outputs to the gates, which stay open. Call after trip_try(): until then nothing
 * that the timer does reaches a gate.
 */
void pwm_connect(void);

/*
 * Starts the counter and places its update event at the peak. The end of the ramp at which a timer
 * updates depends on when the repetition counter was written, and the manuals disagree about this.
 * So this function checks the direction of counting at each update. False when the updates are not
 * at the peak.
 */
bool pwm_start(void);

/* Writes the three preload registers. Context: control interrupt. */
static inline void pwm_write(uint32_t a, uint32_t b, uint32_t c)
{
    reg_write(HAL_CCR_A, a);
    reg_write(HAL_CCR_B, b);
    reg_write(HAL_CCR_C, c);
}

/* Gives all phases equal duty: no voltage between them. Context: control interrupt. */
static inline void pwm_write_rest(void)
{
    const uint32_t half = BOARD.timer_counts / 2U;

    pwm_write(half, half, half);
}

/* Timer ticks since the last peak, 0 to two times timer_counts. Context: any. */
static inline uint32_t pwm_elapsed(void)
{
    const uint32_t count = reg_read(TIM1_CNT);
    const bool down = reg_any(TIM1_CR1, TIM_CR1_DIR);

    return down ? (BOARD.timer_counts - count) : (BOARD.timer_counts + count);
}

#endif
