/* SPDX-License-Identifier: MIT */
#include "pace.h"

#include "board.h"
#include "reg.h"
#include "settings.h"
#include "stm32g4.h"

#include <stdbool.h>
#include <stddef.h>

#define EDGES (8U) /* edges of the oscillator from one capture to the next */
#define OSCILLATOR_MIN_HZ (29500U)
#define OSCILLATOR_MAX_HZ (34000U)
#define CLOCK_OFF_PCT (2U)
#define HUNDRED (100U)
#define SPAN_MIN \
    ((EDGES * (BOARD_CLOCK_HZ / OSCILLATOR_MAX_HZ) * (HUNDRED - CLOCK_OFF_PCT)) / HUNDRED)
#define SPAN_MAX \
    ((EDGES * (BOARD_CLOCK_HZ / OSCILLATOR_MIN_HZ) * (HUNDRED + CLOCK_OFF_PCT)) / HUNDRED)
#define COUNTER_MASK (0xFFFFU)
/*
 * This many wrong spans in a row are a fault. A single one can come from a capture between the
 * reads of the flags and of the count.
 */
#define WRONG_MAX (4U)
#define SILENCE_SHARE (10U) /* no capture for 1/10 s is a fault */

typedef struct {
    uint32_t before;    /* the last capture */
    uint32_t seen_tick; /* tick in which that capture was seen */
    uint8_t wrong;      /* wrong spans in a row */
    bool has_before;
} pace_t;

static pace_t pace;

void pace_init(void)
{
    settings_write(SETTINGS_PACE);
}

/* span: time from one capture to the next, in timer ticks. */
static const char *judge_span(uint32_t span)
{
    const bool is_wrong = (span < SPAN_MIN) || (span > SPAN_MAX);

    pace.wrong = is_wrong ? (uint8_t)(pace.wrong + 1U) : 0U;
    return (pace.wrong >= WRONG_MAX)
               ? "the clock has another speed than its second oscillator allows"
               : NULL;
}

static const char *take_capture(uint32_t tick, bool missed_one)
{
    const uint32_t capture = reg_read(TIM16_CCR1); /* clears CC1IF */
    const uint32_t span = (capture - pace.before) & COUNTER_MASK;
    const char *const why = (pace.has_before && !missed_one) ? judge_span(span) : NULL;

    pace.before = capture;
    pace.has_before = true;
    pace.seen_tick = tick;
    return why;
}

static bool is_silent(uint32_t tick)
{
    const uint32_t ticks_per_second = BOARD_CLOCK_HZ / (2U * BOARD.timer_counts);

    return (tick - pace.seen_tick) > (ticks_per_second / SILENCE_SHARE);
}

const char *pace_step(uint32_t tick)
{
    const uint32_t flags = reg_read(TIM16_SR);
    const char *why = NULL;

    if ((flags & TIM_SR_CC1IF) != 0U) {
        reg_write(TIM16_SR, ~TIM_SR_CC1OF);
        why = take_capture(tick, (flags & TIM_SR_CC1OF) != 0U);
    } else if (is_silent(tick)) {
        why = "the second oscillator stands still";
    } else {
        /* there is no new capture yet */
    }
    return why;
}
