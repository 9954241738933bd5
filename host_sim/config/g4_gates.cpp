// SPDX-License-Identifier: MIT
#include "g4_gates.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr char HIGH_GATES[] = "hal.gate_high_pins";
constexpr char LOW_GATES[] = "hal.gate_low_pins";
constexpr char GATE_ENABLES[] = "hal.gate_enable_pins";

// A gate that nobody drives yet is held off.
Pull gate_off(Polarity polarity)
{
    return polarity == Polarity::active_high ? Pull::down : Pull::up;
}

std::string high_gate_function(int channel)
{
    return fmt::format("TIM1_CH{}", channel);
}

// 0: the pin is no output of timer 1.
int gate_channel(const std::string &pin)
{
    for (int channel = 1; channel <= G4_PHASES; channel++) {
        if (g4_code(pin, high_gate_function(channel)) >= 0) {
            return channel;
        }
    }
    return 0;
}

// Those of the channels that no phase before has.
std::vector<std::string> free_gate_functions(const G4PinBook &book, std::size_t phase)
{
    const auto &channels = book.board().channels;
    std::vector<std::string> functions;
    for (int channel = 1; channel <= G4_PHASES; channel++) {
        if (std::count(channels.begin(), channels.begin() + phase, channel) == 0) {
            functions.push_back(high_gate_function(channel));
        }
    }
    return functions;
}

// Throws if a phase before has the channel.
void need_other_channel(const G4PinBook &book, std::size_t phase, int channel,
                        const std::string &can)
{
    const Pins &pins = book.hal().gate_high_pins;
    for (std::size_t before = 0; before < phase; before++) {
        if (book.board().channels[before] == channel) {
            book.refuse(HIGH_GATES, pins[phase],
                        fmt::format("is on channel {} of timer 1, as {} of phase {} is", channel,
                                    pins[before], "abc"[before]),
                        "three pins of three channels: " + can);
        }
    }
}

void add_high_gate(G4PinBook &book, std::size_t phase)
{
    const std::string &pin = book.hal().gate_high_pins[phase];
    const std::string can = book.free_pins(free_gate_functions(book, phase));
    const int channel = gate_channel(pin);
    book.need_pin(HIGH_GATES, pin, can);
    if (channel == 0) {
        book.refuse(HIGH_GATES, pin,
                    fmt::format("cannot drive the gate of phase {}: it is no channel of timer 1",
                                "abc"[phase]),
                    can);
    }
    book.add(HIGH_GATES, g4_of_phase(HIGH_GATES, phase),
             {pin, "", PinMode::alternate, g4_code(pin, high_gate_function(channel)),
              gate_off(book.hal().gate_high_polarity), false},
             can);
    need_other_channel(book, phase, channel, can);
    book.board().channels[phase] = channel;
}

// A low gate or an enable.
void add_second_gate(G4PinBook &book, const char *key, const std::string &pin, std::size_t phase,
                     Polarity polarity)
{
    const std::string function = high_gate_function(book.board().channels[phase]) + "N";
    const std::string can = book.free_pins({function});
    book.need_pin(key, pin, can);
    if (g4_code(pin, function) < 0) {
        book.refuse(key, pin,
                    fmt::format("cannot belong to {}, which hal.gate_high_pins has for phase {}",
                                book.hal().gate_high_pins[phase], "abc"[phase]),
                    can);
    }
    book.add(key, g4_of_phase(key, phase),
             {pin, "", PinMode::alternate, g4_code(pin, function), gate_off(polarity), false}, can);
}

// The enables are active high: the timer's idle levels open the gates so.
void check_enables(const G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    if (!hal.gate_low_pins.empty()) {
        book.refuse(GATE_ENABLES, g4_shown(hal.gate_enable_pins), "is beside hal.gate_low_pins",
                    "one of the two: low gates, or enables of a driver with one input a phase");
    }
    if (hal.gate_low_polarity != Polarity::active_high) {
        book.refuse("hal.gate_low_polarity", "\"active_low\"",
                    "is for low gates, and this board has hal.gate_enable_pins",
                    "enables that are active high, and no such line");
    }
}

} // namespace

void resolve_g4_gates(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    const bool enables = !hal.gate_enable_pins.empty();
    const char *const key = enables ? GATE_ENABLES : LOW_GATES;
    const Pins &others = enables ? hal.gate_enable_pins : hal.gate_low_pins;
    const std::string three = "3 pins, of phases a, b, c";
    if (enables) {
        check_enables(book);
    }
    book.need_count(HIGH_GATES, hal.gate_high_pins, G4_PHASES, three);
    book.need_count(key, others, G4_PHASES,
                    others.empty()
                        ? three + "; or hal.gate_enable_pins for a driver with one input "
                                  "and one enable a phase"
                        : three);
    for (std::size_t phase = 0; phase < G4_PHASES; phase++) {
        add_high_gate(book, phase);
    }
    for (std::size_t phase = 0; phase < G4_PHASES; phase++) {
        add_second_gate(book, key, others[phase], phase,
                        enables ? Polarity::active_high : hal.gate_low_polarity);
    }
}

} // namespace nf
