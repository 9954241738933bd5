// SPDX-License-Identifier: MIT
#include "g4_analogue.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr char SHUNTS[] = "hal.shunt_pins";
constexpr char SHUNT_GROUNDS[] = "hal.shunt_ground_pins";
// What each chip of the family has.
constexpr int G4_CONVERTERS = 2; // ADC1 and ADC2
constexpr int G4_AMPLIFIERS = 3;
constexpr int G4_COMPARATORS = 4;
// RM0440, interconnection of amplifiers and converters: inside of the chip.
constexpr G4Input AMPLIFIER_INSIDE[G4_AMPLIFIERS + 1] = {{}, {1, 13}, {2, 16}, {2, 18}};

// "OPAMP1 plus", ... of "OPAMP", 3 and " plus".
std::vector<std::string> numbered_functions(const char *block, int count, const char *rest)
{
    std::vector<std::string> all;
    for (int number = 1; number <= count; number++) {
        all.push_back(fmt::format("{}{}{}", block, number, rest));
    }
    return all;
}

bool uses_amplifiers(const HalSettings &hal)
{
    return hal.pga_gain > 1;
}

// Whether no use has the amplifier, or the comparator, of that number yet.
template <typename Used> bool is_free(const std::vector<Used> &used, int number)
{
    return std::none_of(used.begin(), used.end(),
                        [=](const Used &other) { return other.number == number; });
}

std::vector<G4Input> converter_inputs(const std::string &pin)
{
    std::vector<G4Input> found;
    for (int converter = 1; converter <= G4_CONVERTERS; converter++) {
        const int channel = g4_code(pin, fmt::format("ADC{}", converter));
        if (channel >= 0) {
            found.push_back({converter, channel});
        }
    }
    return found;
}

void add_converter_input(G4PinBook &book, const std::string &key, const std::string &use,
                         const std::string &pin)
{
    const std::string can = book.free_pins(numbered_functions("ADC", G4_CONVERTERS, ""));
    book.need_pin(key, pin, can);
    if (converter_inputs(pin).empty()) {
        book.refuse(key, pin, "is no input of converter 1 or 2", can);
    }
    book.add_analogue(key, use, pin, can);
}

// ---- amplifiers ----

std::optional<G4Amplifier> amplifier_for(const G4Board &board, const std::string &plus,
                                         const std::string &minus)
{
    for (int number = 1; number <= G4_AMPLIFIERS; number++) {
        const int code = g4_code(plus, fmt::format("OPAMP{} plus", number));
        if (code >= 0 && is_free(board.amplifiers, number) &&
            g4_code(minus, fmt::format("OPAMP{} minus", number)) >= 0) {
            return G4Amplifier{number, code, false};
        }
    }
    return std::nullopt;
}

// "1 has PA1, PA3 and PA3, ...": the inputs of the amplifiers that are left.
std::string amplifier_inputs(const G4PinBook &book)
{
    std::string text;
    for (int number = 1; number <= G4_AMPLIFIERS; number++) {
        if (is_free(book.board().amplifiers, number)) {
            text += fmt::format("{}amplifier {}: plus {}, minus {}", text.empty() ? "" : "; ",
                                number, book.free_pins({fmt::format("OPAMP{} plus", number)}),
                                book.free_pins({fmt::format("OPAMP{} minus", number)}));
        }
    }
    return text;
}

void add_amplified_shunt(G4PinBook &book, std::size_t phase)
{
    const std::string &plus = book.hal().shunt_pins[phase];
    const std::string &minus = book.hal().shunt_ground_pins[phase];
    const std::string can = amplifier_inputs(book);
    book.need_pin(SHUNTS, plus, can);
    book.need_pin(SHUNT_GROUNDS, minus, can);
    const std::optional<G4Amplifier> found = amplifier_for(book.board(), plus, minus);
    if (!found) {
        book.refuse(
            SHUNTS, plus,
            fmt::format("is no plus input of a free amplifier whose minus input is {}, which "
                        "hal.shunt_ground_pins has for phase {}",
                        minus, "abc"[phase]),
            can);
    }
    book.add_analogue(SHUNTS, g4_of_phase(SHUNTS, phase), plus, can);
    book.board().amplifiers.push_back(*found);
}

void check_shunt_counts(const G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    const auto phases = static_cast<std::size_t>(book.config().board.current_sensors);
    book.need_count(SHUNTS, hal.shunt_pins, phases,
                    fmt::format("{} pins, as board.current_sensors says", phases));
    if (uses_amplifiers(hal)) {
        book.need_count(SHUNT_GROUNDS, hal.shunt_ground_pins, phases,
                        fmt::format("{} pins: the minus inputs of the chip's amplifiers, which "
                                    "hal.pga_gain = {} needs",
                                    phases, hal.pga_gain));
    } else {
        book.need_count(SHUNT_GROUNDS, hal.shunt_ground_pins, 0,
                        "none with hal.pga_gain = 1, which uses no amplifier of the chip");
    }
}

void add_shunts(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    check_shunt_counts(book);
    for (std::size_t phase = 0; phase < hal.shunt_pins.size(); phase++) {
        if (uses_amplifiers(hal)) {
            add_amplified_shunt(book, phase);
        } else {
            add_converter_input(book, SHUNTS, g4_of_phase(SHUNTS, phase), hal.shunt_pins[phase]);
        }
    }
    for (std::size_t phase = 0; phase < hal.shunt_ground_pins.size(); phase++) {
        book.add_analogue(SHUNT_GROUNDS, g4_of_phase(SHUNT_GROUNDS, phase),
                          hal.shunt_ground_pins[phase], amplifier_inputs(book));
    }
}

// ---- comparators ----

std::optional<G4Comparator> comparator_for(const G4Board &board, const std::string &pin)
{
    for (int number = 1; number <= G4_COMPARATORS; number++) {
        const int code = g4_code(pin, fmt::format("COMP{} plus", number));
        if (code >= 0 && is_free(board.comparators, number)) {
            return G4Comparator{number, code};
        }
    }
    return std::nullopt;
}

// ---- converters ----

std::string amplifier_output_pin(int number)
{
    for (const G4Function &row : g4_table()) {
        if (row.what == fmt::format("OPAMP{} output", number)) {
            return row.pin;
        }
    }
    return "";
}

// Where a phase can be sampled: an amplifier's output pin comes before the path in the chip.
std::vector<G4Input> phase_inputs(const G4PinBook &book, std::size_t phase)
{
    if (!uses_amplifiers(book.hal())) {
        return converter_inputs(book.hal().shunt_pins[phase]);
    }
    const int number = book.board().amplifiers[phase].number;
    const std::string output = amplifier_output_pin(number);
    std::vector<G4Input> inputs =
        book.is_taken(output) ? std::vector<G4Input>{} : converter_inputs(output);
    inputs.push_back(AMPLIFIER_INSIDE[number]);
    return inputs;
}

// Two inputs on different converters, the first choices first.
std::optional<std::pair<G4Input, G4Input>> two_converters(const std::vector<G4Input> &ones,
                                                          const std::vector<G4Input> &others)
{
    for (const G4Input &one : ones) {
        for (const G4Input &other : others) {
            if (one.converter != other.converter) {
                return std::pair(one, other);
            }
        }
    }
    return std::nullopt;
}

// The table's "ADC1" pins that have no use yet, and those of ADC2.
std::string free_converter_pins(const G4PinBook &book)
{
    return fmt::format("converter 1: {}; converter 2: {}", book.free_pins({"ADC1"}),
                       book.free_pins({"ADC2"}));
}

// Phases a and b at one instant.
void assign_first_two(G4PinBook &book)
{
    const Pins &pins = book.hal().shunt_pins;
    const auto found = two_converters(phase_inputs(book, 0), phase_inputs(book, 1));
    if (!found) {
        book.refuse(SHUNTS, g4_shown(pins),
                    fmt::format("has {} and {} on one converter only, which cannot sample phases a "
                                "and b at once",
                                pins[0], pins[1]),
                    "one of them on each converter. Free are, " + free_converter_pins(book));
    }
    book.board().currents = {found->first, found->second};
}

// Then the bus and phase c.
void assign_bus_and_third(G4PinBook &book)
{
    const std::string &pin = book.hal().bus_pin;
    book.board().bus = converter_inputs(pin).front();
    if (book.hal().shunt_pins.size() < G4_PHASES) {
        return;
    }
    const auto found = two_converters(converter_inputs(pin), phase_inputs(book, 2));
    if (!found) {
        book.refuse("hal.bus_pin", pin,
                    fmt::format("is on one converter only, with {} of phase c, and each converter "
                                "samples one of them after phases a and b",
                                book.hal().shunt_pins[2]),
                    "one of them on each converter. Free are, " + free_converter_pins(book));
    }
    book.board().bus = found->first;
    book.board().currents.push_back(found->second);
}

// An output pin that nothing else uses is left to its amplifier.
void choose_amplifier_outputs(G4PinBook &book)
{
    G4Board &board = book.board();
    for (std::size_t phase = 0; phase < board.amplifiers.size(); phase++) {
        G4Amplifier &amplifier = board.amplifiers[phase];
        const G4Input inside = AMPLIFIER_INSIDE[amplifier.number];
        const G4Input taken = board.currents[phase];
        const std::string pin = amplifier_output_pin(amplifier.number);
        amplifier.internal = inside.converter == taken.converter && inside.channel == taken.channel;
        if (!book.is_taken(pin)) {
            book.add_analogue(SHUNTS, fmt::format("the output of amplifier {}", amplifier.number),
                              pin, "");
        }
    }
}

} // namespace

void add_g4_inputs(G4PinBook &book)
{
    const HalSettings &hal = book.hal();
    add_shunts(book);
    add_converter_input(book, "hal.bus_pin", "hal.bus_pin", hal.bus_pin);
    add_converter_input(book, "hal.temperature_pin", "hal.temperature_pin", hal.temperature_pin);
    if (!hal.throttle_pin.empty()) {
        add_converter_input(book, "hal.throttle_pin", "hal.throttle_pin", hal.throttle_pin);
    }
}

void add_g4_comparators(G4PinBook &book)
{
    for (std::size_t phase = 0; phase < book.hal().shunt_pins.size(); phase++) {
        const std::string &pin = book.hal().shunt_pins[phase];
        const std::optional<G4Comparator> found = comparator_for(book.board(), pin);
        if (!found) {
            book.refuse(SHUNTS, pin,
                        fmt::format("reaches no free comparator that could open the gates at an "
                                    "over-current of phase {}",
                                    "abc"[phase]),
                        book.free_pins(numbered_functions("COMP", G4_COMPARATORS, " plus")) +
                            ", each comparator once (PA1 and PB1 share one, PA7 and PA3, PA0 and "
                            "PC1); or hal.break_pin for the fault line of a gate driver");
        }
        book.board().comparators.push_back(*found);
    }
}

void assign_g4_converters(G4PinBook &book)
{
    assign_first_two(book);
    assign_bus_and_third(book);
    choose_amplifier_outputs(book);
    book.board().temperature = converter_inputs(book.hal().temperature_pin).front();
    if (!book.hal().throttle_pin.empty()) {
        book.board().throttle = converter_inputs(book.hal().throttle_pin).front();
    }
}

} // namespace nf
