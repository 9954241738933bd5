/* SPDX-License-Identifier: MIT */
/*
 * Two guards of the control tick.
 *
 * The tick guard, SysTick, is restarted by each control interrupt when it is entered, and has the
 * higher priority. When one and a half PWM periods have passed without an entry, a tick was
 * skipped, or hangs: the gates open, and the watchdog is never fed again.
 *
 * The independent watchdog runs from its own oscillator, whatever happens to the rest, and resets
 * the chip after 1 ms (0.9 to 1.2 ms, by the oscillator's 29.5 to 34 kHz) without food. The
 * background feeds it, and only when a control tick has been completed since: so it bites when
 * ticks stop, and when the background does.
 */
#ifndef GUARD_H
#define GUARD_H

#include "board.h"
#include "reg.h"
#include "stm32g431.h"

#include <stdbool.h>

/* Start both. Call right before the first tick can come. False when the watchdog does not start. */
bool guard_start(void);

/* Whether the watchdog made the last reset; forgets it. Call once. */
bool guard_has_bitten(void);

/*
 * Hold the control interrupt back, and let the tick guard rest; then go on from the next
 * conversion. The gates have to be open, and the watchdog has to be fed within its time. Context:
 * background.
 */
void guard_hold_ticks(void);
void guard_release_ticks(void);

/*
 * Let the watchdog wait for 47 ms and more, for an erase of the flash, and then for its own time
 * again. Both feed it. False when it does not take the time over. Context: background, while ticks
 * are held.
 */
bool guard_be_patient(void);
bool guard_be_strict(void);

/* Restart the tick guard. Context: control interrupt, first. */
static inline void guard_restart(void)
{
    reg_write(SYST_CVR, 0U);
}

/* Context: background, behind a completed tick. */
static inline void guard_feed(void)
{
    reg_write(IWDG_KR, IWDG_KR_FEED);
}

#endif
