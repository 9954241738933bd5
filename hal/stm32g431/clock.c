/* SPDX-License-Identifier: MIT */
#include "clock.h"

#include "board.h"
#include "reg.h"
#include "stm32g431.h"

#define AF_TIM1_CH1N (4U) /* function of the pins CH1N and CH3N */
#define AF_TIM1 (6U)
#define AF_USART2 (7U)

#define PORT_BYTES (GPIOB - GPIOA)
#define PIN_NAME_ROOM (5U)

typedef struct {
    uint8_t port; /* 0: port A */
    uint8_t number;
    uint8_t mode;
    uint8_t function;
    uint8_t resistor;
    char name[PIN_NAME_ROOM];
} pin_t;

/* The gates come first. */
#define GATES (6U)

/*
 * The gate pins are pulled down, so the gates are open while the timer does not drive them yet. The
 * other pins are the serial line, shunts, amplifier outputs, bus voltage, temperature, and the LED.
 */
static const pin_t PINS[] = {
    {0U, 8U, GPIO_MODE_ALTERNATE, AF_TIM1, GPIO_PULL_DOWN, "PA8"},
    {0U, 9U, GPIO_MODE_ALTERNATE, AF_TIM1, GPIO_PULL_DOWN, "PA9"},
    {0U, 10U, GPIO_MODE_ALTERNATE, AF_TIM1, GPIO_PULL_DOWN, "PA10"},
    {2U, 13U, GPIO_MODE_ALTERNATE, AF_TIM1_CH1N, GPIO_PULL_DOWN, "PC13"},
    {0U, 12U, GPIO_MODE_ALTERNATE, AF_TIM1, GPIO_PULL_DOWN, "PA12"},
    {1U, 15U, GPIO_MODE_ALTERNATE, AF_TIM1_CH1N, GPIO_PULL_DOWN, "PB15"},
    {1U, 3U, GPIO_MODE_ALTERNATE, AF_USART2, 0U, "PB3"},
    {1U, 4U, GPIO_MODE_ALTERNATE, AF_USART2, GPIO_PULL_UP, "PB4"},
    {0U, 0U, GPIO_MODE_ANALOG, 0U, 0U, "PA0"},
    {0U, 1U, GPIO_MODE_ANALOG, 0U, 0U, "PA1"},
    {0U, 2U, GPIO_MODE_ANALOG, 0U, 0U, "PA2"},
    {0U, 3U, GPIO_MODE_ANALOG, 0U, 0U, "PA3"},
    {0U, 5U, GPIO_MODE_ANALOG, 0U, 0U, "PA5"},
    {0U, 6U, GPIO_MODE_ANALOG, 0U, 0U, "PA6"},
    {0U, 7U, GPIO_MODE_ANALOG, 0U, 0U, "PA7"},
    {1U, 0U, GPIO_MODE_ANALOG, 0U, 0U, "PB0"},
    {1U, 1U, GPIO_MODE_ANALOG, 0U, 0U, "PB1"},
    {1U, 2U, GPIO_MODE_ANALOG, 0U, 0U, "PB2"},
    {1U, 14U, GPIO_MODE_ANALOG, 0U, 0U, "PB14"},
    {2U, 6U, GPIO_MODE_OUTPUT, 0U, 0U, "PC6"},
};

#define PIN_COUNT (sizeof(PINS) / sizeof(PINS[0]))

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

/* The oscillator of 16 MHz that feeds the PLL. */
static bool start_oscillator(void)
{
    reg_set(RCC_CR, RCC_CR_HSION);
    return reg_wait(RCC_CR, RCC_CR_HSIRDY, RCC_CR_HSIRDY);
}

static bool start_pll(void)
{
    reg_write(RCC_PLLCFGR, RCC_PLLCFGR_170MHZ);
    reg_set(RCC_CR, RCC_CR_PLLON);
    return reg_wait(RCC_CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY);
}

/* From 16 MHz first to half the speed, then to 170 MHz, so that the regulator can follow. */
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

static bool is_switched_up(void)
{
    return raise_power() && start_oscillator() && start_pll() && switch_to_pll();
}

/* ram.S calls it. */
__attribute__((used)) void clock_init(void)
{
    (void)is_switched_up();
}

bool clock_is_up(void)
{
    return (reg_read(RCC_CFGR) & RCC_CFGR_COUNTED) == (RCC_CFGR_SW_PLL | RCC_CFGR_SWS_PLL);
}

static uint32_t port_of(const pin_t *pin)
{
    return GPIOA + (pin->port * PORT_BYTES);
}

/* Sets the bits of a pin in a register that has two bits per pin. */
static void set_pair(const pin_t *pin, uint32_t offset, uint32_t value)
{
    const uint32_t place = 2U * (uint32_t)pin->number;

    reg_change(port_of(pin) + offset, 3UL << place, value << place);
}

static bool pair_is(const pin_t *pin, uint32_t offset, uint32_t value)
{
    return ((reg_read(port_of(pin) + offset) >> (2U * (uint32_t)pin->number)) & 3U) == value;
}

/* Returns the address of GPIO_AFRL or GPIO_AFRH, whichever holds the pin's function. */
static uint32_t function_address(const pin_t *pin)
{
    return port_of(pin) + GPIO_AFRL + (4U * ((uint32_t)pin->number / 8U));
}

static uint32_t function_place(const pin_t *pin)
{
    return 4U * ((uint32_t)pin->number % 8U);
}

/* Function and resistor come before the mode, so that the pin never has another function. */
static void set_pin(const pin_t *pin)
{
    const uint32_t place = function_place(pin);

    if (pin->mode == GPIO_MODE_ALTERNATE) {
        reg_change(function_address(pin), 0xFUL << place, (uint32_t)pin->function << place);
        set_pair(pin, GPIO_PUPDR, pin->resistor);
        set_pair(pin, GPIO_OSPEEDR, GPIO_SPEED_HIGH);
    }
    set_pair(pin, GPIO_MODER, pin->mode);
}

void clock_pins(void)
{
    enable_clocks(RCC_AHB1ENR, RCC_AHB1ENR_CRC);
    enable_clocks(RCC_AHB2ENR, RCC_AHB2ENR_USED);
    enable_clocks(RCC_APB1ENR1, RCC_APB1ENR1_RTCAPB | RCC_APB1ENR1_USART2);
    enable_clocks(RCC_APB2ENR, RCC_APB2ENR_USED);
    reg_set(PWR_CR1, PWR_CR1_DBP);
    reg_set(PWR_CR3, PWR_CR3_UCPD1_DBDIS);
    for (uint32_t k = 0U; k < PIN_COUNT; k++) {
        set_pin(&PINS[k]);
    }
}

uint32_t clock_pin_count(void)
{
    return PIN_COUNT;
}

bool clock_pin_holds(uint32_t pin)
{
    const pin_t *const it = &PINS[pin];
    const uint32_t function = (reg_read(function_address(it)) >> function_place(it)) & 0xFU;

    return pair_is(it, GPIO_MODER, it->mode) && pair_is(it, GPIO_PUPDR, it->resistor) &&
           (function == it->function);
}

const char *clock_pin_name(uint32_t pin)
{
    return PINS[pin].name;
}

/* The second way to open the gates; the first one is the timer's main output enable. */
void clock_release_gates(void)
{
    for (uint32_t k = 0U; k < GATES; k++) {
        set_pair(&PINS[k], GPIO_MODER, GPIO_MODE_INPUT);
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
