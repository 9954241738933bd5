// SPDX-License-Identifier: MIT
#include "g4_shaft.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr char HALL_SENSORS[] = "hal.hall_pins";
constexpr char LINE_ENCODER[] = "hal.encoder_pins";
constexpr char SPI_ENCODER[] = "hal.spi_encoder_pins";
constexpr int ENCODER_TIMERS[] = {3, 4}; // timer 2 measures pulses
constexpr int HALL_CHANNELS = 3;
constexpr int SPIS = 3;
enum SpiPin {
    SCK,
    MISO,
    MOSI,
    CS,
    SPI_PINS
};

std::string channel_of(int timer, int channel)
{
    return fmt::format("TIM{}_CH{}", timer, channel);
}

// ---- incremental encoder ----

// 0: the pin is no channel 1 of a timer that counts encoders.
int encoder_timer_of(const std::string &pin)
{
    for (const int timer : ENCODER_TIMERS) {
        if (g4_code(pin, channel_of(timer, 1)) >= 0) {
            return timer;
        }
    }
    return 0;
}

// A pin of the encoder, which has to be one of these channels of its timer. Returns the channel.
int add_encoder_pin(G4PinBook &book, std::size_t which, const std::vector<int> &channels)
{
    const int timer = book.board().encoder_timer;
    const std::string &pin = book.hal().encoder_pins[which];
    std::vector<std::string> functions;
    int found = 0;
    for (const int channel : channels) {
        functions.push_back(channel_of(timer, channel));
        found = g4_code(pin, functions.back()) >= 0 ? channel : found;
    }
    const std::string can = book.free_pins(functions);
    book.need_pin(LINE_ENCODER, pin, can);
    if (found == 0) {
        book.refuse(LINE_ENCODER, pin,
                    fmt::format("cannot be {} of the encoder whose A is at {}, on timer {}",
                                "ABZ"[which], book.hal().encoder_pins[0], timer),
                    can);
    }
    book.add(LINE_ENCODER, fmt::format("{}, {}", LINE_ENCODER, "ABZ"[which]),
             {pin, "", PinMode::alternate, g4_code(pin, channel_of(timer, found)), Pull::up, false},
             can);
    return found;
}

void add_encoder(G4PinBook &book)
{
    const Pins &pins = book.hal().encoder_pins;
    if (pins.size() != 3) {
        book.need_count(LINE_ENCODER, pins, 2, "[A, B] or [A, B, Z]");
    }
    const std::string can = book.free_pins({channel_of(3, 1), channel_of(4, 1)});
    book.need_pin(LINE_ENCODER, pins[0], can);
    book.board().encoder_timer = encoder_timer_of(pins[0]);
    if (book.board().encoder_timer == 0) {
        book.refuse(LINE_ENCODER, pins[0], "is no channel 1 of timer 3 or 4, which A needs", can);
    }
    (void)add_encoder_pin(book, 0, {1});
    (void)add_encoder_pin(book, 1, {2});
    if (pins.size() > 2) {
        book.board().index_channel = add_encoder_pin(book, 2, {3, 4});
    }
}

// ---- Hall sensors ----

// The channel of a timer, 1 to 3, at a pin. 0: it has none.
int hall_channel_of(int timer, const std::string &pin)
{
    for (int channel = 1; channel <= HALL_CHANNELS; channel++) {
        if (g4_code(pin, channel_of(timer, channel)) >= 0) {
            return channel;
        }
    }
    return 0;
}

bool has_channels(int timer, const Pins &pins)
{
    unsigned found = 0;
    for (const std::string &pin : pins) {
        found |= 1U << hall_channel_of(timer, pin);
    }
    return pins.size() == HALL_CHANNELS && found == 0xEU;
}

// A pin can be read as it is, whatever its timer makes of it.
void add_hall_pin(G4PinBook &book, std::size_t sensor)
{
    const std::string &pin = book.hal().hall_pins[sensor];
    const int timer = book.board().hall_timer;
    const int channel = timer > 0 ? hall_channel_of(timer, pin) : 0;
    book.add(HALL_SENSORS, fmt::format("{}, sensor {}", HALL_SENSORS, sensor + 1),
             {pin, "", timer > 0 ? PinMode::alternate : PinMode::input,
              timer > 0 ? g4_code(pin, channel_of(timer, channel)) : 0, Pull::up, false},
             G4_ANY_PIN);
}

void add_hall(G4PinBook &book)
{
    const Pins &pins = book.hal().hall_pins;
    const Pins &shared = book.hal().encoder_pins;
    book.need_count(HALL_SENSORS, pins, HALL_CHANNELS, "3 pins, of the sensors 1, 2, 3");
    book.board().hall_timer = g4_hall_timer(book.hal());
    for (std::size_t sensor = 0; sensor < pins.size(); sensor++) {
        const bool twice = std::count(pins.begin(), pins.end(), pins[sensor]) > 1;
        if (twice || std::count(shared.begin(), shared.end(), pins[sensor]) == 0) {
            add_hall_pin(book, sensor);
        }
    }
}

// ---- absolute encoder ----

std::string spi_signal(int number, SpiPin which)
{
    const char *const names[] = {"SCK", "MISO", "MOSI"};
    return fmt::format("SPI{}_{}", number, names[which]);
}

// The interface that has all three pins. 0: there is none.
int spi_of(const Pins &pins)
{
    for (int number = 1; number <= SPIS; number++) {
        bool has_all = true;
        for (const SpiPin which : {SCK, MISO, MOSI}) {
            has_all = has_all && g4_code(pins[which], spi_signal(number, which)) >= 0;
        }
        if (has_all) {
            return number;
        }
    }
    return 0;
}

// "SPI1 with SCK at PA5, MISO at PA6 and MOSI at PA7; ...".
std::string free_spis(const G4PinBook &book)
{
    std::string text;
    for (int number = 1; number <= SPIS; number++) {
        text += fmt::format(
            "{}SPI{} with SCK at {}; MISO at {}; MOSI at {}", text.empty() ? "" : ". Or ", number,
            book.free_pins({spi_signal(number, SCK)}), book.free_pins({spi_signal(number, MISO)}),
            book.free_pins({spi_signal(number, MOSI)}));
    }
    return text;
}

// MISO is pulled up: a sensor that does not answer sends ones, which is an error in its frame.
void add_absolute(G4PinBook &book)
{
    const Pins &pins = book.hal().spi_encoder_pins;
    book.need_count(SPI_ENCODER, pins, SPI_PINS, "[SCK, MISO, MOSI, CS]");
    const std::string can = free_spis(book);
    for (const std::string &pin : pins) {
        book.need_pin(SPI_ENCODER, pin, can);
    }
    const int spi = spi_of(pins);
    if (spi == 0) {
        book.refuse(SPI_ENCODER, g4_shown(pins), "has no SCK, MISO and MOSI of one SPI", can);
    }
    for (const SpiPin which : {SCK, MISO, MOSI}) {
        const std::string signal = spi_signal(spi, which);
        book.add(SPI_ENCODER,
                 fmt::format("{}, {}", SPI_ENCODER, signal.substr(signal.find('_') + 1)),
                 {pins[which], "", PinMode::alternate, g4_code(pins[which], signal),
                  which == MISO ? Pull::up : Pull::none, false},
                 can);
    }
    book.add(SPI_ENCODER, fmt::format("{}, CS", SPI_ENCODER),
             {pins[CS], "", PinMode::output, 0, Pull::none, true}, G4_ANY_PIN);
    book.board().spi = spi;
}

} // namespace

int g4_hall_timer(const HalSettings &hal)
{
    const Pins &encoder = hal.encoder_pins;
    const int taken = encoder.empty() ? 0 : encoder_timer_of(encoder[0]);
    for (const int timer : ENCODER_TIMERS) {
        const bool shared =
            std::all_of(encoder.begin(), encoder.end(), [&](const std::string &pin) {
                return std::count(hal.hall_pins.begin(), hal.hall_pins.end(), pin) > 0;
            });
        if (has_channels(timer, hal.hall_pins) && (timer != taken || shared)) {
            return timer;
        }
    }
    return 0;
}

void add_g4_shaft(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    if (!hal.encoder_pins.empty()) {
        add_encoder(book);
    }
    if (!hal.hall_pins.empty()) {
        add_hall(book);
    }
    if (!hal.spi_encoder_pins.empty()) {
        add_absolute(book);
    }
}

} // namespace nf
