// SPDX-License-Identifier: MIT
#include "g4_pin_book.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf
{

std::string g4_of_phase(const std::string &key, std::size_t phase)
{
    return fmt::format("{}, phase {}", key, "abc"[phase]);
}

std::string g4_shown(const Pins &pins)
{
    return fmt::format("[{}]", fmt::join(pins, ", "));
}

G4PinBook::G4PinBook(const Config &config, const G4Chip &chip) : config_(config)
{
    board_.chip = &chip;
    taken_ = {{"PA13", "the debugger"}, {"PA14", "the debugger"}, {"PG10", "the reset"}};
    if (hal().crystal_hz > 0) {
        taken_.insert(taken_.end(), {{"PF0", "hal.crystal_hz"}, {"PF1", "hal.crystal_hz"}});
    }
}

void G4PinBook::refuse(const std::string &key, const std::string &value, const std::string &problem,
                       const std::string &allowed) const
{
    const auto found = config_.origins.find(key);
    const Origin board_file = {config_.origins.at("board.name").file, 0};
    fail(found == config_.origins.end() ? board_file : found->second, key, value, problem, allowed);
}

void G4PinBook::need_count(const std::string &key, const Pins &pins, std::size_t count,
                           const std::string &allowed) const
{
    if (pins.size() != count) {
        refuse(key, g4_shown(pins),
               fmt::format("has {} pin{}", pins.size(), pins.size() == 1 ? "" : "s"), allowed);
    }
}

void G4PinBook::need_pin(const std::string &key, const std::string &pin,
                         const std::string &can) const
{
    if (!has_g4_pin(*board_.chip, pin)) {
        refuse(key, pin, fmt::format("is no pin of {}", board_.chip->name), can);
    }
}

void G4PinBook::add(const std::string &key, const std::string &use, const G4Pin &pin,
                    const std::string &can)
{
    need_pin(key, pin.name, can);
    if (const std::string *const user = user_of(pin.name); user != nullptr) {
        refuse(key, pin.name, fmt::format("is taken by {}", *user), can);
    }
    taken_.emplace_back(pin.name, use);
    board_.pins.push_back(pin);
    board_.pins.back().use = use;
}

void G4PinBook::add_analogue(const std::string &key, const std::string &use, const std::string &pin,
                             const std::string &can)
{
    add(key, use, {pin, "", PinMode::analog, 0, Pull::none, false}, can);
}

bool G4PinBook::is_taken(const std::string &pin) const
{
    return user_of(pin) != nullptr;
}

std::string G4PinBook::free_pins(const std::vector<std::string> &functions) const
{
    std::vector<std::string> pins = g4_pins_for(*board_.chip, functions);
    pins.erase(std::remove_if(pins.begin(), pins.end(),
                              [&](const std::string &pin) { return is_taken(pin); }),
               pins.end());
    return pins.empty() ? "no pin is left that could" : fmt::format("{}", fmt::join(pins, ", "));
}

const std::string *G4PinBook::user_of(const std::string &pin) const
{
    const auto found = std::find_if(taken_.begin(), taken_.end(),
                                    [&](const auto &other) { return other.first == pin; });
    return found == taken_.end() ? nullptr : &found->second;
}

} // namespace nf
