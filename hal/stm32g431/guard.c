/* SPDX-License-Identifier: MIT */
#include "guard.h"

/* 32 kHz / 4: a count is 125 µs. */
#define WATCHDOG_COUNTS (8U)
#define PATIENT_COUNTS (400U)

/* Above the control interrupt, so that it can end a tick that hangs. */
static void start_tick_guard(void)
{
    const uint32_t period = 2U * BOARD.timer_counts;

    reg_write(SCB_SHPR3, 0U);
    reg_write(NVIC_IPR4, NVIC_ADC1_2_PRIORITY_1);
    reg_write(SYST_RVR, period + (period / 2U) - 1U);
    reg_write(SYST_CVR, 0U);
    reg_write(SYST_CSR, SYST_CSR_RUN);
}

static bool set_watchdog(uint32_t counts)
{
    bool taken;

    reg_write(IWDG_KR, IWDG_KR_UNLOCK);
    reg_write(IWDG_PR, 0U);
    reg_write(IWDG_RLR, counts - 1U);
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
    started = set_watchdog(WATCHDOG_COUNTS);
    start_tick_guard();
    reg_write(NVIC_ISER0, 1UL << NVIC_ADC1_2);
    return started;
}

bool guard_has_bitten(void)
{
    const bool bitten = reg_any(RCC_CSR, RCC_CSR_IWDGRSTF);

    reg_set(RCC_CSR, RCC_CSR_RMVF);
    return bitten;
}

void guard_hold_ticks(void)
{
    guard_feed();
    reg_write(SYST_CSR, 0U);
    reg_write(NVIC_ICER0, 1UL << NVIC_ADC1_2);
}

/* Of the conversions since, none starts a tick: they are old. */
void guard_release_ticks(void)
{
    reg_write(ADC1 + ADC_ISR, ADC_ISR_JEOS | ADC_ISR_JEOC);
    reg_write(NVIC_ICPR0, 1UL << NVIC_ADC1_2);
    reg_write(SYST_CVR, 0U);
    reg_write(SYST_CSR, SYST_CSR_RUN);
    reg_write(NVIC_ISER0, 1UL << NVIC_ADC1_2);
    guard_feed();
}

bool guard_be_patient(void)
{
    return set_watchdog(PATIENT_COUNTS);
}

bool guard_be_strict(void)
{
    return set_watchdog(WATCHDOG_COUNTS);
}
