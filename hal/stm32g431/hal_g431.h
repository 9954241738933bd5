/* SPDX-License-Identifier: MIT */
/*
 * The binding of hal.h to the STM32G431.
 *
 * Order in a control tick: hal_sample() acknowledges the interrupt, restarts the tick guard and
 * puts a rest duty into the preload registers; hal_apply() replaces it by the drive's demand. So a
 * tick that ends too late leaves the rest duty behind, and not the demand of a tick before. Such a
 * tick is counted, and the next frame says so.
 */
#ifndef HAL_G431_H
#define HAL_G431_H

#include "hal.h"

#include <stdbool.h>
#include <stdint.h>

struct hal {
    uint32_t ticks;          /* completed */
    uint32_t overruns;       /* ticks that ended too late: the rest duty acted */
    uint32_t longest;        /* timer ticks from the sampling instant to the end of a tick */
    bool gates_on;           /* asked for and not broken since */
    volatile bool tick_lost; /* set by the tick guard: the watchdog starves */
    volatile bool barred;    /* the gates stay open until a reset */
    const char *why_barred;  /* NULL: a lost tick, or nothing */
    bool late;               /* the last tick ended too late */
    uint16_t phase_c;        /* the third shunt, as the other two; the drive does without it */
    uint16_t temperature;    /* raw counts, the last that was converted */
};

/*
 * Clocks, pins and peripherals, gates open. NULL, or what does not work; then the gates stay open.
 * The clock must have settled.
 */
const char *hal_g431_init(hal_t *hal);

/* Start the first tick. NULL, or what does not work. */
const char *hal_g431_start(void);

/*
 * The chip is not what it should be: the gates open by both ways and stay open until a reset, and
 * the drive sees a break in each frame. `why` outlives the call. Context: background.
 */
void hal_g431_bar(hal_t *hal, const char *why);

/* A tick was skipped or hangs. Context: tick guard's exception. */
void hal_g431_tick_lost(hal_t *hal);

#endif
