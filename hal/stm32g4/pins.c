/* SPDX-License-Identifier: MIT */
#include "pins.h"

#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"

#define PORT_BYTES (GPIOB - GPIOA)
#define PIN_NAME_ROOM (5U)

typedef struct {
    uint8_t port; /* 0: port A */
    uint8_t number;
    uint8_t mode;
    uint8_t function;
    uint8_t resistor;
    bool high; /* level of an output from the start on */
    char name[PIN_NAME_ROOM];
} pin_t;

/* The gates come first. */
#define GATES (6U)

static const pin_t PINS[] = {HAL_PINS};

#define PIN_COUNT (sizeof(PINS) / sizeof(PINS[0]))

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

static void set_level(const pin_t *pin)
{
    const uint32_t set = 1UL << pin->number;

    reg_write(port_of(pin) + GPIO_BSRR, pin->high ? set : (set << GPIO_BSRR_BR0_SHIFT));
}

/* All else comes before the mode, so that the pin never has another function or level. */
static void set_pin(const pin_t *pin)
{
    const uint32_t place = function_place(pin);

    if (pin->mode == GPIO_MODE_OUTPUT) {
        set_level(pin);
    } else if (pin->mode == GPIO_MODE_ALTERNATE) {
        reg_change(function_address(pin), 0xFUL << place, (uint32_t)pin->function << place);
        set_pair(pin, GPIO_OSPEEDR, GPIO_SPEED_HIGH);
    } else {
        /* analogue */
    }
    set_pair(pin, GPIO_PUPDR, pin->resistor);
    set_pair(pin, GPIO_MODER, pin->mode);
}

void pins_init(void)
{
    for (uint32_t k = 0U; k < PIN_COUNT; k++) {
        set_pin(&PINS[k]);
    }
}

uint32_t pins_count(void)
{
    return PIN_COUNT;
}

bool pins_hold(uint32_t pin)
{
    const pin_t *const it = &PINS[pin];
    const uint32_t function = (reg_read(function_address(it)) >> function_place(it)) & 0xFU;

    return pair_is(it, GPIO_MODER, it->mode) && pair_is(it, GPIO_PUPDR, it->resistor) &&
           (function == it->function);
}

const char *pins_name(uint32_t pin)
{
    return PINS[pin].name;
}

void pins_release_gates(void)
{
    for (uint32_t k = 0U; k < GATES; k++) {
        set_pair(&PINS[k], GPIO_MODER, GPIO_MODE_INPUT);
    }
}
