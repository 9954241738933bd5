/* SPDX-License-Identifier: MIT */
// What the pins of the STM32G4 can do that hal/stm32g4 makes use of, chip by chip.
//
// From the data sheets DS12589 (STM32G431) and DS12288 (STM32G474), tables of pins and of alternate
// functions, and RM0440, tables of the comparators' and amplifiers' inputs.
#pragma once

#include <string>
#include <vector>

namespace nf
{

constexpr double G4_CLOCK_HZ = 170e6;     // of core, timers and buses
constexpr double G4_OSCILLATOR_HZ = 16e6; // of the chip's own oscillator

struct G4Chip {
    const char *name; // with the letters of package and flash, such as "stm32g431cb"
    int flash_kib;
    int ram_kib;
    bool two_banks;      // the flash, as shipped
    const char *pins[8]; // of ports A to G by number, such as "0-15"; then nullptr
};

// The chip of that name, or null.
const G4Chip *find_g4_chip(const std::string &name);

// The names.
std::string g4_chip_names();

// Whether the chip's package has a pin, such as "PA8". Any text is allowed.
bool has_g4_pin(const G4Chip &chip, const std::string &pin);

// Port 0 for A, and the number, of a pin that a chip has.
int g4_port(const std::string &pin);
int g4_number(const std::string &pin);

struct G4Function {
    const char *pin;
    const char
        *what; // such as "TIM1_CH1", "ADC1", "OPAMP2 plus", "COMP4 plus", "USART2_TX", "SPI1_SCK"
    int code;  // alternate function, channel of the converter, or code of the input
};

// The code of a pin's function; -1 if it does not have it.
int g4_code(const std::string &pin, const std::string &what);

// The pins of a chip that have one of these functions.
std::vector<std::string> g4_pins_for(const G4Chip &chip, const std::vector<std::string> &functions);

const std::vector<G4Function> &g4_table();

// Each pin of a chip with what the binding can use it for, in the manual's words and with the
// number of an alternate function: "PA9   TIM1_CH2 (6), USART1_TX (7)".
std::string g4_pin_list(const G4Chip &chip);

} // namespace nf
