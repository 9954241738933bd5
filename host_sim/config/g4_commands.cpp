// SPDX-License-Identifier: MIT
#include "g4_commands.h"

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr int PULSE_CHANNELS = 4; // of timer 2, which counts 32 bits
constexpr char PULSES[] = "hal.pulse_pin";
constexpr char BUTTON[] = "hal.button_pin";

std::string pulse_function(int channel)
{
    return fmt::format("TIM2_CH{}", channel);
}

// 0: the pin is no channel of timer 2.
int pulse_channel_of(const std::string &pin)
{
    for (int channel = 1; channel <= PULSE_CHANNELS; channel++) {
        if (g4_code(pin, pulse_function(channel)) >= 0) {
            return channel;
        }
    }
    return 0;
}

// Pulled down: a wire that is open gives no pulses.
void add_pulses(G4PinBook &book)
{
    const std::string &pin = book.hal().pulse_pin;
    const std::string can = book.free_pins(
        {pulse_function(1), pulse_function(2), pulse_function(3), pulse_function(4)});
    const int channel = pulse_channel_of(pin);
    book.need_pin(PULSES, pin, can);
    if (channel == 0) {
        book.refuse(PULSES, pin, "is no channel of timer 2, which measures pulses", can);
    }
    book.add(
        PULSES, PULSES,
        {pin, "", PinMode::alternate, g4_code(pin, pulse_function(channel)), Pull::down, false},
        can);
    book.board().pulse_channel = channel;
}

// Pulled to the level at rest: a wire that is open is a button that nobody presses.
void add_button(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    const bool low = hal.button_polarity == Polarity::active_low;
    book.add(BUTTON, BUTTON,
             {hal.button_pin, "", PinMode::input, 0, low ? Pull::up : Pull::down, false},
             G4_ANY_PIN);
}

} // namespace

void add_g4_commands(G4PinBook &book)
{
    if (!book.hal().pulse_pin.empty()) {
        add_pulses(book);
    }
    if (!book.hal().button_pin.empty()) {
        add_button(book);
    }
}

} // namespace nf
