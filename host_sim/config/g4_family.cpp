// SPDX-License-Identifier: MIT
#include "g4_family.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf
{
namespace
{

constexpr int PORT_PINS = 16;

// clang-format off
const std::vector<G4Function> TABLE = {
    {"PA8", "TIM1_CH1", 6},
    {"PC0", "TIM1_CH1", 2},
    {"PA9", "TIM1_CH2", 6},
    {"PC1", "TIM1_CH2", 2},
    {"PA10", "TIM1_CH3", 6},
    {"PC2", "TIM1_CH3", 2},
    {"PA7", "TIM1_CH1N", 6},
    {"PA11", "TIM1_CH1N", 6},
    {"PB13", "TIM1_CH1N", 6},
    {"PC13", "TIM1_CH1N", 4},
    {"PA12", "TIM1_CH2N", 6},
    {"PB0", "TIM1_CH2N", 6},
    {"PB14", "TIM1_CH2N", 6},
    {"PB1", "TIM1_CH3N", 6},
    {"PB9", "TIM1_CH3N", 12},
    {"PB15", "TIM1_CH3N", 4},
    {"PF0", "TIM1_CH3N", 6},
    {"PA6", "TIM1_BKIN", 6},
    {"PA14", "TIM1_BKIN", 6},
    {"PA15", "TIM1_BKIN", 9},
    {"PB8", "TIM1_BKIN", 12},
    {"PB10", "TIM1_BKIN", 12},
    {"PB12", "TIM1_BKIN", 6},
    {"PC13", "TIM1_BKIN", 2},
    {"PA0", "ADC1", 1},
    {"PA1", "ADC1", 2},
    {"PA2", "ADC1", 3},
    {"PA3", "ADC1", 4},
    {"PB0", "ADC1", 15},
    {"PB1", "ADC1", 12},
    {"PB11", "ADC1", 14},
    {"PB12", "ADC1", 11},
    {"PB14", "ADC1", 5},
    {"PC0", "ADC1", 6},
    {"PC1", "ADC1", 7},
    {"PC2", "ADC1", 8},
    {"PC3", "ADC1", 9},
    {"PF0", "ADC1", 10},
    {"PA0", "ADC2", 1},
    {"PA1", "ADC2", 2},
    {"PA4", "ADC2", 17},
    {"PA5", "ADC2", 13},
    {"PA6", "ADC2", 3},
    {"PA7", "ADC2", 4},
    {"PB2", "ADC2", 12},
    {"PB11", "ADC2", 14},
    {"PB15", "ADC2", 15},
    {"PC0", "ADC2", 6},
    {"PC1", "ADC2", 7},
    {"PC2", "ADC2", 8},
    {"PC3", "ADC2", 9},
    {"PC4", "ADC2", 5},
    {"PC5", "ADC2", 11},
    {"PF1", "ADC2", 10},
    {"PA1", "COMP1 plus", 0},
    {"PB1", "COMP1 plus", 1},
    {"PA3", "COMP2 plus", 1},
    {"PA7", "COMP2 plus", 0},
    {"PA0", "COMP3 plus", 0},
    {"PC1", "COMP3 plus", 1},
    {"PB0", "COMP4 plus", 0},
    {"PA3", "OPAMP1 minus", 0},
    {"PA2", "OPAMP1 output", 0},
    {"PA1", "OPAMP1 plus", 0},
    {"PA3", "OPAMP1 plus", 1},
    {"PA7", "OPAMP1 plus", 2},
    {"PA5", "OPAMP2 minus", 0},
    {"PA6", "OPAMP2 output", 0},
    {"PA7", "OPAMP2 plus", 0},
    {"PB0", "OPAMP2 plus", 2},
    {"PB14", "OPAMP2 plus", 1},
    {"PB2", "OPAMP3 minus", 0},
    {"PB1", "OPAMP3 output", 0},
    {"PA1", "OPAMP3 plus", 2},
    {"PB0", "OPAMP3 plus", 0},
    {"PB13", "OPAMP3 plus", 1},
    {"PF0", "OSC_IN", 0},
    {"PF1", "OSC_OUT", 0},
    {"PA6", "SPI1_MISO", 5},
    {"PB4", "SPI1_MISO", 5},
    {"PA7", "SPI1_MOSI", 5},
    {"PB5", "SPI1_MOSI", 5},
    {"PA5", "SPI1_SCK", 5},
    {"PB3", "SPI1_SCK", 5},
    {"PA10", "SPI2_MISO", 5},
    {"PB14", "SPI2_MISO", 5},
    {"PA11", "SPI2_MOSI", 5},
    {"PB15", "SPI2_MOSI", 5},
    {"PB13", "SPI2_SCK", 5},
    {"PF1", "SPI2_SCK", 5},
    {"PB4", "SPI3_MISO", 6},
    {"PC11", "SPI3_MISO", 6},
    {"PB5", "SPI3_MOSI", 6},
    {"PC12", "SPI3_MOSI", 6},
    {"PB3", "SPI3_SCK", 6},
    {"PC10", "SPI3_SCK", 6},
    {"PA0", "TIM2_CH1", 1},
    {"PA5", "TIM2_CH1", 1},
    {"PA15", "TIM2_CH1", 1},
    {"PA1", "TIM2_CH2", 1},
    {"PB3", "TIM2_CH2", 1},
    {"PA2", "TIM2_CH3", 1},
    {"PA9", "TIM2_CH3", 10},
    {"PB10", "TIM2_CH3", 1},
    {"PA3", "TIM2_CH4", 1},
    {"PA10", "TIM2_CH4", 10},
    {"PB11", "TIM2_CH4", 1},
    {"PA6", "TIM3_CH1", 2},
    {"PB4", "TIM3_CH1", 2},
    {"PC6", "TIM3_CH1", 2},
    {"PA4", "TIM3_CH2", 2},
    {"PA7", "TIM3_CH2", 2},
    {"PB5", "TIM3_CH2", 2},
    {"PC7", "TIM3_CH2", 2},
    {"PB0", "TIM3_CH3", 2},
    {"PC8", "TIM3_CH3", 2},
    {"PB1", "TIM3_CH4", 2},
    {"PB7", "TIM3_CH4", 10},
    {"PC9", "TIM3_CH4", 2},
    {"PA11", "TIM4_CH1", 10},
    {"PB6", "TIM4_CH1", 2},
    {"PA12", "TIM4_CH2", 10},
    {"PB7", "TIM4_CH2", 2},
    {"PA13", "TIM4_CH3", 10},
    {"PB8", "TIM4_CH3", 2},
    {"PB9", "TIM4_CH4", 2},
    {"PA10", "USART1_RX", 7},
    {"PB7", "USART1_RX", 7},
    {"PC5", "USART1_RX", 7},
    {"PA9", "USART1_TX", 7},
    {"PB6", "USART1_TX", 7},
    {"PC4", "USART1_TX", 7},
    {"PA3", "USART2_RX", 7},
    {"PA15", "USART2_RX", 7},
    {"PB4", "USART2_RX", 7},
    {"PA2", "USART2_TX", 7},
    {"PA14", "USART2_TX", 7},
    {"PB3", "USART2_TX", 7},
    {"PB8", "USART3_RX", 7},
    {"PB11", "USART3_RX", 7},
    {"PC11", "USART3_RX", 7},
    {"PB9", "USART3_TX", 7},
    {"PB10", "USART3_TX", 7},
    {"PC10", "USART3_TX", 7},
};

// Packages with 48 pins (C) and 64 pins (R).
const std::vector<G4Chip> CHIPS = {
    {"stm32g431cb", 128, 32, false, {"0-15", "0-15", "4,6,10,11,13-15", "", "", "0,1", "10"}},
    {"stm32g431rb", 128, 32, false, {"0-15", "0-15", "0-15", "2", "", "0,1", "10"}},
    {"stm32g474ce", 512, 128, true, {"0-15", "0-15", "4,6,10,11,13-15", "", "", "0,1", "10"}},
    {"stm32g474re", 512, 128, true, {"0-15", "0-15", "0-15", "2", "", "0,1", "10"}},
};
// clang-format on

// Whether a list such as "4,6,13-15" has the number.
bool lists(const char *list, int number)
{
    bool found = false;
    for (const char *at = list; *at != '\0' && !found;) {
        char *end = nullptr;
        const long first = std::strtol(at, &end, 10);
        const long last = *end == '-' ? std::strtol(end + 1, &end, 10) : first;
        found = number >= first && number <= last;
        at = *end == ',' ? end + 1 : end;
    }
    return found;
}

// "ADC1" and its channel as "ADC1_IN3", "COMP2 plus" as "COMP2_INP0", "TIM1_CH1" as "TIM1_CH1 (6)".
std::string manual_name(const G4Function &row)
{
    const std::string what = row.what;
    const std::string block = what.substr(0, what.find(' '));
    if (what.rfind("ADC", 0) == 0) {
        return fmt::format("{}_IN{}", what, row.code);
    }
    if (what.rfind("COMP", 0) == 0) {
        return fmt::format("{}_INP{}", block, row.code);
    }
    if (what.rfind("OPAMP", 0) == 0) {
        const bool plus = what == block + " plus";
        return block + (plus ? fmt::format("_VINP{}", row.code)
                             : (what == block + " minus" ? "_VINM0" : "_VOUT"));
    }
    return row.code > 0 ? fmt::format("{} ({})", what, row.code) : "RCC_" + what;
}

} // namespace

const std::vector<G4Function> &g4_table()
{
    return TABLE;
}

const G4Chip *find_g4_chip(const std::string &name)
{
    const auto found = std::find_if(CHIPS.begin(), CHIPS.end(),
                                    [&](const G4Chip &chip) { return chip.name == name; });
    return found == CHIPS.end() ? nullptr : &*found;
}

std::string g4_chip_names()
{
    std::vector<std::string> names;
    names.reserve(CHIPS.size());
    for (const G4Chip &chip : CHIPS) {
        names.emplace_back(chip.name);
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

bool has_g4_pin(const G4Chip &chip, const std::string &pin)
{
    const bool shaped =
        (pin.size() == 3 || pin.size() == 4) && pin[0] == 'P' && pin[1] >= 'A' && pin[1] <= 'G' &&
        std::all_of(pin.begin() + 2, pin.end(), [](char c) { return c >= '0' && c <= '9'; }) &&
        (pin.size() == 3 || pin[2] != '0');
    return shaped && g4_number(pin) < PORT_PINS && lists(chip.pins[g4_port(pin)], g4_number(pin));
}

int g4_port(const std::string &pin)
{
    return pin[1] - 'A';
}

int g4_number(const std::string &pin)
{
    return static_cast<int>(std::strtol(pin.c_str() + 2, nullptr, 10));
}

int g4_code(const std::string &pin, const std::string &what)
{
    const auto found = std::find_if(TABLE.begin(), TABLE.end(), [&](const G4Function &row) {
        return row.pin == pin && row.what == what;
    });
    return found == TABLE.end() ? -1 : found->code;
}

std::vector<std::string> g4_pins_for(const G4Chip &chip, const std::vector<std::string> &functions)
{
    std::vector<std::string> pins;
    for (const G4Function &row : TABLE) {
        const bool can = std::find(functions.begin(), functions.end(), row.what) != functions.end();
        if (can && has_g4_pin(chip, row.pin) &&
            std::count(pins.begin(), pins.end(), row.pin) == 0) {
            pins.emplace_back(row.pin);
        }
    }
    return pins;
}

std::string g4_pin_list(const G4Chip &chip)
{
    std::string text;
    for (const char *port = "ABCDEFG"; *port != '\0'; port++) {
        for (int number = 0; number < PORT_PINS; number++) {
            const std::string pin = fmt::format("P{}{}", *port, number);
            std::vector<std::string> names;
            for (const G4Function &row : TABLE) {
                if (row.pin == pin) {
                    names.push_back(manual_name(row));
                }
            }
            if (has_g4_pin(chip, pin)) {
                text += fmt::format("{:<5} {}\n", pin, fmt::join(names, ", "));
            }
        }
    }
    return text;
}

} // namespace nf
