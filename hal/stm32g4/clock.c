/* SPDX-License-Identifier: MIT */
#include "clock.h"

#include "board.h"
#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"

#include <stddef.h>
#include <stdint.h>

/*
 * The clocks run at half the speed for at least 1 µs before the whole one. A read takes at least 8
 * cycles of 85 MHz, so this many take 6 µs.
 */
#define READS_AT_HALF_SPEED (64U)

/*
 * A capture comes at each eighth edge of the crystal's clock divided by 32. BOARD.crystal_span is
 * the time of so many captures, in cycles of the oscillator.
 */
#define CAPTURES (8U)
#define OFF_PCT (3U) /* the oscillator's 2 %, and what counts and crystal are off by */
#define HUNDRED (100U)
#define COUNTER_MASK (0xFFFFU)

/*
 * A peripheral must not be accessed in the two cycles after its clock was enabled, RM0440 7.2. The
 * read takes longer than that.
 */
static void enable_clocks(uint32_t address, uint32_t bits)
{
    reg_set(address, bits);
    (void)reg_read(address);
}

static bool raise_power(void)
{
    enable_clocks(RCC_APB1ENR1, RCC_APB1ENR1_PWR);
    reg_clear(PWR_CR5, PWR_CR5_R1MODE);
    reg_change(FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_LATENCY_4);
    reg_set(FLASH_ACR, FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    return reg_wait(PWR_CR5, PWR_CR5_R1MODE, 0U) && reg_wait(PWR_SR2, PWR_SR2_VOSF, 0U) &&
           reg_wait(FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_LATENCY_4);
}

/* The oscillator in the chip. */
static bool start_oscillator(void)
{
    reg_set(RCC_CR, RCC_CR_HSION);
    return reg_wait(RCC_CR, RCC_CR_HSIRDY, RCC_CR_HSIRDY);
}

/*
 * TIM16 captures the crystal's clock against the oscillator, which still clocks the core. The
 * register of the captures belongs to pace.c later.
 */
static void begin_captures(void)
{
    enable_clocks(RCC_APB2ENR, RCC_APB2ENR_TIM16);
    reg_write(TIM16_TISEL, TIM16_TISEL_HSE_32);
    reg_write(TIM16_CCMR1, TIM_CCMR_CAPTURE_EIGHTH);
    reg_write(TIM16_CCER, TIM_CCER_CC1E);
    reg_write(TIM16_CR1, TIM_CR1_CEN);
}

static void end_captures(void)
{
    reg_write(TIM16_CR1, 0U);
    reg_write(TIM16_CCER, 0U);
    reg_write(TIM16_SR, 0U);
}

/* Returns the count at the next capture. If none comes, the span is wrong. */
static uint32_t next_capture(void)
{
    (void)reg_wait(TIM16_SR, TIM_SR_CC1IF, TIM_SR_CC1IF);
    return reg_read(TIM16_CCR1);
}

static bool has_right_frequency(void)
{
    uint32_t first;
    uint32_t span = 0U;

    begin_captures();
    (void)next_capture(); /* it may have begun before the counter */
    first = next_capture();
    for (uint32_t k = 0U; k < CAPTURES; k++) {
        span = (next_capture() - first) & COUNTER_MASK;
    }
    end_captures();
    return ((span * HUNDRED) > (BOARD.crystal_span * (HUNDRED - OFF_PCT))) &&
           ((span * HUNDRED) < (BOARD.crystal_span * (HUNDRED + OFF_PCT)));
}

static bool start_crystal(void)
{
    reg_set(RCC_CR, RCC_CR_HSEON);
    return reg_wait(RCC_CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && has_right_frequency();
}

static bool start_pll(uint32_t settings)
{
    reg_write(RCC_PLLCFGR, settings);
    reg_set(RCC_CR, RCC_CR_PLLON);
    return reg_wait(RCC_CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY);
}

/* RM0440 6.1.5 and 7.2.7: to the whole speed by way of half of it. */
static bool switch_to_pll(void)
{
    bool is_switched;

    reg_change(RCC_CFGR, RCC_CFGR_HPRE, RCC_CFGR_HPRE_2);
    reg_change(RCC_CFGR, RCC_CFGR_SW, RCC_CFGR_SW_PLL);
    is_switched = reg_wait(RCC_CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_PLL);
    if (is_switched) {
        for (uint32_t k = 0U; k < READS_AT_HALF_SPEED; k++) {
            (void)reg_read(RCC_CFGR);
        }
        reg_clear(RCC_CFGR, RCC_CFGR_HPRE);
    }
    return is_switched;
}

/* The PLL's settings: of the crystal, if there is one and it is right. */
static uint32_t pll_settings(void)
{
    uint32_t settings = RCC_PLLCFGR_INSIDE;

    if ((BOARD.crystal_span > 0U) && start_crystal()) {
        settings = HAL_PLL;
    }
    return settings;
}

/* ram.S calls it. */
__attribute__((used)) void clock_init(void)
{
    if (raise_power() && start_oscillator() && start_pll(pll_settings())) {
        (void)switch_to_pll();
    }
}

bool clock_is_up(void)
{
    return (reg_read(RCC_CFGR) & RCC_CFGR_COUNTED) == (RCC_CFGR_SW_PLL | RCC_CFGR_SWS_PLL);
}

const char *clock_crystal_fault(void)
{
    const char *why = NULL;

    if ((BOARD.crystal_span == 0U) || (reg_read(RCC_PLLCFGR) == HAL_PLL)) {
        /* as the board file says */
    } else if (reg_any(RCC_CR, RCC_CR_HSERDY)) {
        why = "the crystal has not the frequency of hal.crystal_hz";
    } else {
        why = "the crystal of hal.crystal_hz does not start";
    }
    return why;
}

void clock_peripherals(void)
{
    enable_clocks(RCC_AHB1ENR, HAL_AHB1);
    enable_clocks(RCC_AHB2ENR, HAL_AHB2);
    enable_clocks(RCC_APB1ENR1, HAL_APB1);
    enable_clocks(RCC_APB2ENR, HAL_APB2);
    reg_set(PWR_CR1, PWR_CR1_DBP);
    reg_set(PWR_CR3, PWR_CR3_UCPD1_DBDIS);
    reg_set(RCC_CR, HAL_CR & RCC_CR_CSSON);
}

bool clock_has_lost_crystal(void)
{
    return (BOARD.crystal_span > 0U) && reg_any(RCC_CIFR, RCC_CIFR_CSSF);
}

/* The chip switches to the oscillator, and the PLL off, by itself. */
static bool has_fallen_back(void)
{
    return start_oscillator() && reg_wait(RCC_CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_HSI) &&
           reg_wait(RCC_CR, RCC_CR_PLLRDY, 0U);
}

void clock_do_without_crystal(void)
{
    reg_write(RCC_CICR, RCC_CICR_CSSC);
    if (has_fallen_back() && start_pll(RCC_PLLCFGR_INSIDE)) {
        (void)switch_to_pll();
    }
}

void clock_wait_us(unsigned int us)
{
    reg_write(SYST_RVR, (us * (BOARD_CLOCK_HZ / 1000000U)) - 1U);
    reg_write(SYST_CVR, 0U);
    reg_write(SYST_CSR, SYST_CSR_COUNT);
    (void)reg_wait(SYST_CSR, SYST_CSR_COUNTFLAG, SYST_CSR_COUNTFLAG);
    reg_write(SYST_CSR, 0U);
}
