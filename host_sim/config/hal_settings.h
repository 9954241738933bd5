/* SPDX-License-Identifier: MIT */
// [hal] of a board file: what a target's hardware binding has to know beyond [board]. Optional;
// asked for only when a header for a binding is made.
#pragma once

#include <string>
#include <vector>

namespace nf
{

// A level of a signal: of a gate, of the line or the comparator that opens the gates, of an LED.
enum class Polarity {
    active_high,
    active_low
};

// Where the shunts are.
enum class CurrentPosition {
    low_side,
    in_line
};

using Pins = std::vector<std::string>; // such as "PA8"; of several phases in the order a, b, c

struct HalSettings {
    std::string chip = "other"; // a chip that hal/stm32g4 serves; with "other" pins do not count
    double crystal_hz = 0;      // 0: the oscillator in the chip
    Pins gate_high_pins;
    Pins gate_low_pins;    // none: the driver has one input and one enable for each phase
    Pins gate_enable_pins; // of such a driver
    Polarity gate_high_polarity = Polarity::active_high;
    Polarity gate_low_polarity = Polarity::active_high;
    Pins shunt_pins;
    Pins shunt_ground_pins;
    CurrentPosition current_position = CurrentPosition::low_side;
    std::string bus_pin;
    std::string temperature_pin;
    std::string break_pin; // "": the chip's comparators look at the shunts
    Polarity break_polarity = Polarity::active_high; // of that line, or of what trips a comparator
    Pins high_pins; // outputs that stay high, or low, from the start on
    Pins low_pins;
    double driver_wake_us = 0; // after high_pins and low_pins are set
    Pins serial_pins;          // TX, RX
    std::string throttle_pin;  // "": there is none, as for the two below
    std::string pulse_pin;
    std::string button_pin;
    Polarity button_polarity = Polarity::active_low; // while it is pressed
    Pins hall_pins;                                  // sensors 1, 2, 3; none: there are none
    Pins encoder_pins;                               // A, B and, if there is an index, Z
    Pins spi_encoder_pins;                           // SCK, MISO, MOSI, CS
    std::string led_pin;                             // "": there is none
    Polarity led_polarity = Polarity::active_high;
    double adc_settling_ns = 0; // low side on before its shunt can be sampled
    double adc_sampling_ns = 0; // sample switch closed
    double shunt_ohm = 0;
    double amplifier_gain = 0;   // shunt to converter; negative: current into the motor counts down
    double amplifier_zero_v = 0; // at the converter, without current
    // the part of the gain behind the comparators' inputs; 1: all of it is before them
    int pga_gain = 0;
    double adc_reference_v = 0;
    double bus_divider = 0; // bus to converter
};

} // namespace nf
