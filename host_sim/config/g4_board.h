/* SPDX-License-Identifier: MIT */
// What a board file's [hal] comes to for hal/stm32g4: which peripherals its pins are.
#pragma once

#include "g4_family.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

enum class PinMode {
    input,
    output,
    alternate,
    analog
};

enum class Pull {
    none,
    up,
    down
};

struct G4Pin {
    std::string name;
    std::string use; // such as "hal.gate_high_pins, phase a"
    PinMode mode;
    int function; // number of the alternate function
    Pull pull;
    bool high; // of an output: its level from the start on
};

struct G4Amplifier {
    int number;
    int plus;      // code of its plus input
    bool internal; // its output goes to the converter inside of the chip only
};

struct G4Comparator {
    int number;
    int plus;
};

// A conversion: channel of converter 1 or 2.
struct G4Input {
    int converter = 0;
    int channel = 0;
};

struct G4Board {
    const G4Chip *chip = nullptr;
    std::vector<G4Pin> pins;       // the gates first
    std::array<int, 3> channels{}; // TIM1's, of phases a, b, c
    std::vector<G4Amplifier> amplifiers;
    std::vector<G4Comparator> comparators; // none: the break pin
    std::vector<G4Input> currents;         // of two or three phases
    G4Input bus;
    G4Input temperature;
    int usart = 0;
    std::optional<G4Input> throttle;
    int pulse_channel = 0; // of timer 2; 0: none
    int encoder_timer = 0; // 3 or 4; 0: no incremental encoder
    int index_channel = 0; // of that timer, 3 or 4; 0: no index
    int hall_timer = 0;    // 3 or 4, which takes the time of Hall edges; 0: none
    int spi = 0;           // of the absolute encoder; 0: none
    int pll_divider = 4;   // M and N of 16 MHz or the crystal, for 170 MHz
    int pll_factor = 85;
};

} // namespace nf
