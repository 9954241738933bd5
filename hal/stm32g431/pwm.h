/* SPDX-License-Identifier: MIT */
/*
 * TIM1: centre-aligned complementary PWM on three half bridges. RM0440 28.3.
 *
 * PWM mode 1: the high side is on while the counter is below the compare value, thus the low side
 * around the counter's peak. The update event comes once a period, at the peak: it loads the
 * compare values, and as TRGO2 it starts the converters. So the instant of sampling is the instant
 * of loading, the middle of the low sides' on-time.
 *
 * Break. The comparators of trip.h clear the main output enable (MOE) without the core; then all
 * six outputs are low. The same do a lockup of the core, a wrong parity of the RAM and a supply
 * that sinks. Dead time, break and idle levels are locked until reset.
 */
#ifndef PWM_H
#define PWM_H

#include "board.h"
#include "reg.h"
#include "stm32g431.h"

#include <stdbool.h>
#include <stdint.h>

/* Flags of a break: of the comparators, and of the system. */
#define PWM_BREAK_FLAGS (TIM_SR_BIF | TIM_SR_SBIF)

/* All but the outputs and the counter's start; gates open. */
void pwm_init(void);

/*
 * The outputs to the gates, which stay open. Call when the trip has been tried: until then nothing
 * that the timer does reaches a gate.
 */
void pwm_connect(void);

/*
 * Start the counter and bring its update event to the peak. Which end of its ramp a timer updates
 * at depends on when the repetition counter was written, and manuals differ in it; so this looks at
 * the direction of counting and leaves nothing to trust. False when the timer does not obey.
 */
bool pwm_start(void);

/* The three preload registers. Context: control interrupt. */
static inline void pwm_write(uint32_t a, uint32_t b, uint32_t c)
{
    reg_write(TIM1_CCR1, a);
    reg_write(TIM1_CCR2, b);
    reg_write(TIM1_CCR3, c);
}

/* All phases alike: no voltage between them. Context: control interrupt. */
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
