/* SPDX-License-Identifier: MIT */
#include "guard.h"

#include "hal_config.h"
#include "settings.h"

/* Reload value of the watchdog: number of counts − 1. A count takes 125 µs: 32 kHz / 4. */
#define IWDG_RLR_PATIENT (399U)
#define IWDG_RLR_START (4095U) /* the longest */

static bool is_guarding; /* guard_start() has run */

/*
 * Starts the tick guard. Its priority is above the control interrupt, so that it also comes during
 * a tick that hangs.
 */
static void start_tick_guard(void)
{
    settings_write(SETTINGS_GUARD);
    reg_write(SYST_CVR, 0U);
    reg_write(SYST_CSR, SYST_CSR_RUN);
}

static bool set_watchdog(uint32_t reload)
{
    bool taken;

    reg_write(IWDG_KR, IWDG_KR_UNLOCK);
    reg_write(IWDG_PR, 0U);
    reg_write(IWDG_RLR, reload);
    taken = reg_wait(IWDG_SR, 0xFFFFFFFFU, 0U);
    guard_feed();
    return taken;
}

bool guard_start(void)
{
    bool started;

    reg_write(DBGMCU_APB1FZR1, DBGMCU_IWDG_STOP);
    reg_write(DBGMCU_APB2FZ, DBGMCU_TIM1_STOP);
    reg_write(IWDG_KR, IWDG_KR_START);
    started = set_watchdog(IWDG_RLR_STRICT);
    start_tick_guard();
    reg_write(NVIC_ISER0, 1UL << NVIC_ADC1_2);
    is_guarding = true;
    return started;
}

void guard_watch_start(void)
{
    reg_write(IWDG_KR, IWDG_KR_START);
    (void)set_watchdog(IWDG_RLR_START);
}

void guard_hold_ticks(void)
{
    guard_feed();
    if (is_guarding) {
        reg_write(SYST_CSR, 0U);
        reg_write(NVIC_ICER0, 1UL << NVIC_ADC1_2);
    }
}

/* Conversions that have ended meanwhile are old, so they must not start a tick. */
void guard_release_ticks(void)
{
    if (is_guarding) {
        reg_write(HAL_ADC_LAST + ADC_ISR, ADC_ISR_JEOS | ADC_ISR_JEOC);
        reg_write(NVIC_ICPR0, 1UL << NVIC_ADC1_2);
        reg_write(SYST_CVR, 0U);
        reg_write(SYST_CSR, SYST_CSR_RUN);
        reg_write(NVIC_ISER0, 1UL << NVIC_ADC1_2);
    }
    guard_feed();
}

/* Sets a time of the watchdog while the ticks are guarded. */
static bool set_usual_watchdog(uint32_t reload)
{
    bool taken = true;

    if (is_guarding) {
        taken = set_watchdog(reload);
    } else {
        guard_feed();
    }
    return taken;
}

bool guard_be_patient(void)
{
    return set_usual_watchdog(IWDG_RLR_PATIENT);
}

bool guard_be_strict(void)
{
    return set_usual_watchdog(IWDG_RLR_STRICT);
}
