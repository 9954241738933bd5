/* SPDX-License-Identifier: MIT */
// The words that a person may use for signals, states and faults.
#pragma once

#include "expression.h"
#include "signals.h"

#include <string>
#include <vector>

namespace nf::debug
{

// A signal, and whether its raw value is meant: NAME.raw.
struct Named {
    const SignalInfo *signal;
    bool raw;
};

// Throws std::runtime_error with the near names.
Named named_signal(const std::string &name);

// Signals in SI units, their raw values, states and faults as numbers. Throws like named_signal().
Value named_value(const std::string &name);

// "speed_rpm 999.8 rpm"; a word of the firmware with its raw value and format, and with what a
// recording has of it.
std::string signal_line(const Named &named, const Tick &tick);

// All signals, states and faults.
const std::vector<std::string> &all_words();

} // namespace nf::debug
