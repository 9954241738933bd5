/* SPDX-License-Identifier: MIT */
#include "clock.h"

#include "board.h"
#include "reg.h"
#include "stm32g431.h"

#define WAIT_STATES_170MHZ (4U)

#define AF_TIM1_CH1N (4U) /* also CH3N */
#define AF_TIM1 (6U)
#define AF_USART2 (7U)

typedef struct {
    uint32_t port;
    uint32_t pin;
    uint32_t function;
    uint32_t resistor;
} pin_t;

/* Shunts, amplifier outputs, bus voltage, temperature. */
#define ANALOG_A \
    ((1UL << 0) | (1UL << 1) | (1UL << 2) | (1UL << 3) | (1UL << 5) | (1UL << 6) | (1UL << 7))
#define ANALOG_B ((1UL << 0) | (1UL << 1) | (1UL << 2) | (1UL << 14))

#define LED_PIN (6U)

/* A block takes no access in the two cycles after its clock was enabled, RM0440 7.2: the reading lasts longer. */
static void enable_clocks(uint32_t address, uint32_t bits)
{
    reg_set(address, bits);
    (void)reg_read(address);
}

static bool raise_power(void)
{
    enable_clocks(RCC_APB1ENR1, RCC_APB1ENR1_PWR);
    reg_clear(PWR_CR5, PWR_CR5_R1MODE);
    reg_change(FLASH_ACR, FLASH_ACR_LATENCY, WAIT_STATES_170MHZ);
    reg_set(FLASH_ACR, FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    return reg_wait(PWR_CR5, PWR_CR5_R1MODE, 0U) && reg_wait(PWR_SR2, PWR_SR2_VOSF, 0U) &&
           reg_wait(FLASH_ACR, FLASH_ACR_LATENCY, WAIT_STATES_170MHZ);
}

/* The oscillator of 16 MHz, from which the PLL is fed. */
static bool start_oscillator(void)
{
    reg_set(RCC_CR, RCC_CR_HSION);
    return reg_wait(RCC_CR, RCC_CR_HSIRDY, RCC_CR_HSIRDY);
}

static bool start_pll(void)
{
    reg_write(RCC_PLLCFGR,
              RCC_PLLCFGR_SRC_HSI16 | RCC_PLLCFGR_M_4 | RCC_PLLCFGR_N_85 | RCC_PLLCFGR_REN);
    reg_set(RCC_CR, RCC_CR_PLLON);
    return reg_wait(RCC_CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY);
}

/* The step from 16 to 170 MHz goes by way of half the speed, so that the regulator can follow. */
static bool switch_to_pll(void)
{
    reg_change(RCC_CFGR, RCC_CFGR_HPRE, RCC_CFGR_HPRE_2);
    reg_change(RCC_CFGR, RCC_CFGR_SW, RCC_CFGR_SW_PLL);
    const bool is_switched = reg_wait(RCC_CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_PLL);
    if (is_switched) {
        clock_wait_us(1U);
        reg_clear(RCC_CFGR, RCC_CFGR_HPRE);
    }
    return is_switched;
}

bool clock_init(void)
{
    return raise_power() && start_oscillator() && start_pll() && switch_to_pll();
}

static void set_mode(uint32_t port, uint32_t pin, uint32_t mode)
{
    reg_change(port + GPIO_MODER, 3UL << (2U * pin), mode << (2U * pin));
}

/* Function and resistor first: the pin must not show another function for a moment. */
static void set_alternate(const pin_t *pin)
{
    const uint32_t half = pin->port + GPIO_AFRL + (4U * (pin->pin / 8U));
    const uint32_t nibble = 4U * (pin->pin % 8U);

    reg_change(half, 0xFUL << nibble, pin->function << nibble);
    reg_change(pin->port + GPIO_PUPDR, 3UL << (2U * pin->pin), pin->resistor << (2U * pin->pin));
    reg_change(pin->port + GPIO_OSPEEDR, 3UL << (2U * pin->pin),
               GPIO_SPEED_HIGH << (2U * pin->pin));
    set_mode(pin->port, pin->pin, GPIO_MODE_ALTERNATE);
}

static void set_analog(uint32_t port, uint32_t pins)
{
    for (uint32_t pin = 0U; pin < 16U; pin++) {
        if ((pins & (1UL << pin)) != 0U) {
            set_mode(port, pin, GPIO_MODE_ANALOG);
        }
    }
}

#define PINS (8U)

void clock_pins(void)
{
    /* The gates' are pulled down: open while the timer does not drive yet. */
    static const pin_t pins[PINS] = {
        {GPIOA, 8U, AF_TIM1, GPIO_PULL_DOWN},
        {GPIOA, 9U, AF_TIM1, GPIO_PULL_DOWN},
        {GPIOA, 10U, AF_TIM1, GPIO_PULL_DOWN},
        {GPIOC, 13U, AF_TIM1_CH1N, GPIO_PULL_DOWN},
        {GPIOA, 12U, AF_TIM1, GPIO_PULL_DOWN},
        {GPIOB, 15U, AF_TIM1_CH1N, GPIO_PULL_DOWN},
        {GPIOB, 3U, AF_USART2, 0U},
        {GPIOB, 4U, AF_USART2, GPIO_PULL_UP},
    };

    enable_clocks(RCC_AHB2ENR, RCC_AHB2ENR_GPIOA | RCC_AHB2ENR_GPIOB | RCC_AHB2ENR_GPIOC |
                                   RCC_AHB2ENR_ADC12 | RCC_AHB2ENR_DAC3);
    enable_clocks(RCC_APB1ENR1, RCC_APB1ENR1_USART2);
    enable_clocks(RCC_APB2ENR, RCC_APB2ENR_SYSCFG | RCC_APB2ENR_TIM1);
    reg_set(PWR_CR3, PWR_CR3_UCPD1_DBDIS);
    for (uint32_t k = 0U; k < PINS; k++) {
        set_alternate(&pins[k]);
    }
    set_analog(GPIOA, ANALOG_A);
    set_analog(GPIOB, ANALOG_B);
    set_mode(GPIOC, LED_PIN, GPIO_MODE_OUTPUT);
}

void clock_wait_us(unsigned int us)
{
    reg_write(SYST_RVR, (us * (BOARD_CLOCK_HZ / 1000000U)) - 1U);
    reg_write(SYST_CVR, 0U);
    reg_write(SYST_CSR, SYST_CSR_COUNT);
    (void)reg_wait(SYST_CSR, SYST_CSR_COUNTFLAG, SYST_CSR_COUNTFLAG);
    reg_write(SYST_CSR, 0U);
}
