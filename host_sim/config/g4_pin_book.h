/* SPDX-License-Identifier: MIT */
// The pins of a board file while they get their uses: each pin has one.
#pragma once

#include "configuration.h"
#include "g4_board.h"
#include "g4_family.h"
#include "origin.h"

#include <string>
#include <utility>
#include <vector>

namespace nf
{

constexpr int G4_PHASES = 3;
constexpr char G4_ANY_PIN[] = "a pin that nothing else uses";

// "hal.shunt_pins, phase b" of "hal.shunt_pins" and 1.
std::string g4_of_phase(const std::string &key, std::size_t phase);

// "[PA8, PA9]".
std::string g4_shown(const Pins &pins);

class G4PinBook
{
public:
    // Taken from the start on: the debugger, the reset and the crystal.
    G4PinBook(const Config &config, const G4Chip &chip);

    const Config &config() const
    {
        return config_;
    }

    const HalSettings &hal() const
    {
        return config_.hal;
    }

    // What has been found so far.
    G4Board &board()
    {
        return board_;
    }

    const G4Board &board() const
    {
        return board_;
    }

    // Throws ConfigError at the key's place.
    [[noreturn]] void refuse(const std::string &key, const std::string &value,
                             const std::string &problem, const std::string &allowed) const;

    // Throws unless a list has so many pins.
    void need_count(const std::string &key, const Pins &pins, std::size_t count,
                    const std::string &allowed) const;

    // Throws unless the chip's package has the pin.
    void need_pin(const std::string &key, const std::string &pin, const std::string &can) const;

    // Gives the pin its use. Throws if the chip does not have it or if it has a use. `can` says
    // what else the user can write.
    void add(const std::string &key, const std::string &use, const G4Pin &pin,
             const std::string &can);

    // The same for an analogue pin.
    void add_analogue(const std::string &key, const std::string &use, const std::string &pin,
                      const std::string &can);

    bool is_taken(const std::string &pin) const;

    // The pins that have one of these functions and no use yet.
    std::string free_pins(const std::vector<std::string> &functions) const;

private:
    const Config &config_;
    G4Board board_;
    std::vector<std::pair<std::string, std::string>> taken_; // pin, what it is for

    const std::string *user_of(const std::string &pin) const;
};

} // namespace nf
