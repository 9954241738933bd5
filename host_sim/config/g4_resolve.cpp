// SPDX-License-Identifier: MIT
#include "g4_resolve.h"

#include "g4_analogue.h"
#include "g4_commands.h"
#include "g4_gates.h"
#include "g4_pin_book.h"
#include "g4_shaft.h"

#include <cmath>
#include <optional>
#include <tuple>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double CRYSTAL_MIN_HZ = 4e6; // data sheet
constexpr double PLL_IN_MIN_HZ = 2.66e6;
constexpr double PLL_IN_MAX_HZ = 16e6;
constexpr double PLL_IN_BEST_HZ = 4e6;
constexpr int PLL_DIVIDER_MAX = 16;
constexpr int PLL_FACTOR_MIN = 8;
constexpr int PLL_FACTOR_MAX = 127;
constexpr int USARTS = 3;

// M and N of the PLL for a clock of 170 MHz. Its input is as near to 4 MHz as can be.
std::optional<std::pair<int, int>> pll_for(double hz)
{
    std::optional<std::pair<int, int>> best;
    double least = HUGE_VAL;
    for (int divider = 1; divider <= PLL_DIVIDER_MAX; divider++) {
        const double in = hz / divider;
        const double factor = 2 * G4_CLOCK_HZ / in;
        const bool is_exact = in >= PLL_IN_MIN_HZ && in <= PLL_IN_MAX_HZ &&
                              factor == std::round(factor) && factor >= PLL_FACTOR_MIN &&
                              factor <= PLL_FACTOR_MAX;
        if (is_exact && std::fabs(in - PLL_IN_BEST_HZ) < least) {
            best = {divider, static_cast<int>(factor)};
            least = std::fabs(in - PLL_IN_BEST_HZ);
        }
    }
    return best;
}

void resolve_clock(G4PinBook &book)
{
    const double crystal = book.hal().crystal_hz;
    const auto found = crystal == 0                ? pll_for(G4_OSCILLATOR_HZ)
                       : crystal >= CRYSTAL_MIN_HZ ? pll_for(crystal)
                                                   : std::nullopt;
    if (!found) {
        book.refuse("hal.crystal_hz", fmt::format("{:.10g}", crystal), "gives no clock of 170 MHz",
                    "0 for the oscillator in the chip, or a crystal such as 8000000, 16000000, "
                    "24000000 or 25000000 Hz");
    }
    std::tie(book.board().pll_divider, book.board().pll_factor) = *found;
}

void add_held_outputs(G4PinBook &book)
{
    const std::tuple<const char *, const Pins *, bool> lists[] = {
        {"hal.high_pins", &book.hal().high_pins, true},
        {"hal.low_pins", &book.hal().low_pins, false}};
    for (const auto &[key, pins, high] : lists) {
        for (const std::string &pin : *pins) {
            book.add(key, key, {pin, "", PinMode::output, 0, Pull::none, high}, G4_ANY_PIN);
        }
    }
}

// ---- trip ----

void add_break_line(G4PinBook &book)
{
    constexpr char KEY[] = "hal.break_pin";
    const std::string &pin = book.hal().break_pin;
    const std::string can = book.free_pins({"TIM1_BKIN"});
    book.need_pin(KEY, pin, can);
    if (g4_code(pin, "TIM1_BKIN") < 0) {
        book.refuse(KEY, pin, "does not reach the break input of timer 1", can);
    }
    if (book.config().board.trip_a > 0) {
        book.refuse("board.trip_a", fmt::format("{:g}", book.config().board.trip_a),
                    "has no effect beside hal.break_pin, where the gate driver has its own limit",
                    "one of the two: no board.trip_a, or no hal.break_pin and the chip's "
                    "comparators at hal.shunt_pins");
    }
    // A gate driver's line is an open drain as a rule: somebody has to pull it.
    const bool low = book.hal().break_polarity == Polarity::active_low;
    book.add(KEY, KEY,
             {pin, "", PinMode::alternate, g4_code(pin, "TIM1_BKIN"), low ? Pull::up : Pull::down,
              false},
             can);
}

void resolve_trip(G4PinBook &book)
{
    if (book.hal().break_pin.empty()) {
        add_g4_comparators(book);
    } else {
        add_break_line(book);
    }
}

// ---- serial line and LED ----

constexpr char SERIAL_LINE[] = "hal.serial_pins";

// 0: the pin is no TX.
int usart_of(const std::string &tx)
{
    for (int number = 1; number <= USARTS; number++) {
        if (g4_code(tx, fmt::format("USART{}_TX", number)) >= 0) {
            return number;
        }
    }
    return 0;
}

void add_serial_pin(G4PinBook &book, const std::string &pin, const std::string &signal, Pull pull,
                    const std::string &problem, const std::string &can)
{
    const int code = g4_code(pin, fmt::format("USART{}_{}", book.board().usart, signal));
    book.need_pin(SERIAL_LINE, pin, can);
    if (code < 0) {
        book.refuse(SERIAL_LINE, pin, problem, can);
    }
    book.add(SERIAL_LINE, fmt::format("{}, {}", SERIAL_LINE, signal),
             {pin, "", PinMode::alternate, code, pull, false}, can);
}

void add_serial_line(G4PinBook &book)
{
    const Pins &pins = book.hal().serial_pins;
    book.need_count(SERIAL_LINE, pins, 2, "[TX, RX]");
    const int usart = usart_of(pins[0]);
    book.board().usart = usart;
    add_serial_pin(book, pins[0], "TX", Pull::none, "is no TX of USART1, 2 or 3",
                   book.free_pins({"USART1_TX", "USART2_TX", "USART3_TX"}));
    add_serial_pin(book, pins[1], "RX", Pull::up,
                   fmt::format("is no RX of USART{}, whose TX {} is", usart, pins[0]),
                   book.free_pins({fmt::format("USART{}_RX", usart)}));
}

void add_light(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    if (!hal.led_pin.empty()) {
        book.add("hal.led_pin", "hal.led_pin",
                 {hal.led_pin, "", PinMode::output, 0, Pull::none,
                  hal.led_polarity == Polarity::active_low},
                 G4_ANY_PIN);
    }
}

} // namespace

G4Board resolve_g4_board(const Config &config)
{
    G4PinBook book(config, *find_g4_chip(config.hal.chip));
    resolve_clock(book);
    resolve_g4_gates(book);
    add_held_outputs(book);
    add_g4_inputs(book);
    resolve_trip(book);
    add_serial_line(book);
    add_light(book);
    add_g4_commands(book);
    add_g4_shaft(book);
    assign_g4_converters(book);
    return book.board();
}

} // namespace nf
