/* SPDX-License-Identifier: MIT */
/*
 * The binding of hal.h to the STM32G4.
 *
 * Order in a control tick: hal_sample() acknowledges the interrupt, restarts the tick guard and
 * puts a rest duty into the preload registers; hal_apply() replaces it by the drive's demand. So if
 * a tick ends too late, the rest duty acts, and not the demand of an earlier tick. Such a tick is
 * counted, and the next frame reports it.
 */
#ifndef HAL_G4_H
#define HAL_G4_H

#include "hal.h"
#include "stm32g4.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * Backup registers beside those of hal_keep(): the exception that nobody expected, and the mark of
 * ram.h.
 */
#define HAL_G4_EXCEPTION (TAMP_BKP0R + (4U * HAL_KEPT_WORDS))
#define HAL_G4_RAM_MARK (HAL_G4_EXCEPTION + 4U)

struct hal {
    uint32_t ticks;    /* completed control ticks */
    uint32_t overruns; /* ticks that ended too late: the rest duty acted */
    uint32_t longest;  /* timer ticks from the sampling instant to the end of a tick */
    /* the drive has enabled the gates, and no break has opened them since */
    bool gates_on;
    volatile bool tick_lost; /* set by the tick guard; then the watchdog is not fed any more */
    volatile bool barred;    /* the gates stay open until a reset */
    /* the fault of the chip; NULL: barred by a lost tick, or not barred */
    const char *why_barred;
    bool late;            /* the last tick ended too late */
    uint16_t phase_c;     /* count of the third phase, as adc_ia; drive_step() does not use it */
    uint16_t temperature; /* raw counts of the last conversion */
    uint16_t throttle;    /* the same of the throttle; HAL_NO_THROTTLE: there is none */
    uint8_t conversions;  /* hal_inputs_t.conversions */
    bool asked;           /* a conversion of one of the two was started in the last tick */
    hal_reset_t reset;    /* the last reset */
};

/*
 * Sets up the peripherals with open gates. Returns NULL, or a text that says what does not work;
 * then the gates stay open. Call after pins_init(). The clock must have settled.
 */
const char *hal_g4_init(hal_t *hal);

/*
 * Takes note of the last reset, and forgets its traces in the chip. Call once, when the clocks of
 * the peripherals are on.
 */
void hal_g4_note_reset(hal_t *hal);

/* Starts the control ticks. Returns NULL, or a text that says what does not work. */
const char *hal_g4_start(void);

/*
 * Call when a check has found a fault of the chip. The gates open in both ways, by the timer and by
 * the pins, and stay open until a reset. The drive sees a break in each frame. `why` must outlive
 * the call; the first reason is kept. Context: background or NMI.
 */
void hal_g4_bar(hal_t *hal, const char *why);

/* Call when a tick was skipped or hangs. Context: tick guard's exception. */
void hal_g4_tick_lost(hal_t *hal);

#endif
