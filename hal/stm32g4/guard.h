/* SPDX-License-Identifier: MIT */
/*
 * Two guards of the control tick.
 *
 * The tick guard is SysTick. Each control interrupt restarts it at its entry. The guard has the
 * higher priority. When one and a half PWM periods pass without a restart, a tick was skipped or
 * hangs: the gates open, and the watchdog is never fed again.
 *
 * The independent watchdog has its own oscillator, so it runs whatever happens to the rest of the
 * chip. It resets the chip when it has not been fed for 1 ms (0.9 to 1.2 ms with the oscillator's
 * 29.5 to 34 kHz). The background feeds it only when a control tick has been completed since the
 * last time. So the chip is reset when the ticks stop, and also when the background stops.
 */
#ifndef GUARD_H
#define GUARD_H

#include "board.h"
#include "reg.h"
#include "stm32g4.h"

#include <stdbool.h>

/* Starts both. Call right before the first tick can come. False if the watchdog does not start. */
bool guard_start(void);

/*
 * Starts the watchdog alone, with 0.44 s or more, for a part of the start that a reset has to end
 * if it does not. guard_start() sets the usual time.
 */
void guard_watch_start(void);

/*
 * guard_hold_ticks() disables the control interrupt and stops the tick guard.
 * guard_release_ticks() starts both again, and the next conversion gives the next tick. Both feed
 * the watchdog. The gates have to be open in between, and the time in between has to be shorter
 * than the time of the watchdog. Before guard_start() they only feed. Context: background.
 */
void guard_hold_ticks(void);
void guard_release_ticks(void);

/*
 * guard_be_patient() lets the watchdog wait for 47 ms or more, for an erase of the flash.
 * guard_be_strict() sets its usual time again. Both feed it. False when it does not take over the
 * time. Before guard_start() they only feed. Context: background, while the control interrupt is
 * disabled.
 */
bool guard_be_patient(void);
bool guard_be_strict(void);

/* Restarts the tick guard. Context: control interrupt, first. */
static inline void guard_restart(void)
{
    reg_write(SYST_CVR, 0U);
}

/* Feeds the watchdog. Context: background, after a completed tick, or when no tick can come. */
static inline void guard_feed(void)
{
    reg_write(IWDG_KR, IWDG_KR_FEED);
}

#endif
