/* SPDX-License-Identifier: MIT */
// Every signal of a run by its name: what the motor does, what the drive believes, each word of the
// drive's state and configuration. One table for traces, for the debugger and for whoever asks by
// name.
//
// Names without a dot are quantities of the run, their unit at the end, and read as they are. Names
// with a dot are words of the firmware, named as there: in., out., drive., cfg. Such a word has a
// raw value, the format that says what one of it means, and the SI value that this makes.
#pragma once

#include "cfg_rows.h"
#include "tick.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

// An integer of the firmware: where it is, and how large it may be.
struct Word {
    enum class Home {
        in,
        out,
        drive,
        cfg
    };
    Home home;
    std::size_t offset;
    std::size_t bytes;
    bool has_sign;
    const char *member; // of its home: "voltage.d"
};

struct SignalInfo {
    const char *name;
    Quantity quantity;
    double (*value)(const Tick &); // NULL for a word
    Word word;
    const CfgRow *row; // of a word of the configuration, else NULL
    // Whether the drive knows it now; NULL: always. What it does not know is what it was when
    // driving ended.
    bool (*known)(const drive_t &drive) = nullptr;
};

const std::vector<SignalInfo> &all_signals();

// NULL when there is none of this name.
const SignalInfo *find_signal(const std::string &name);

// For an unknown name: those it may have meant or else the least unlike, the nearest first, at most
// `count`.
std::vector<std::string> near_signals(const std::string &name, std::size_t count);

// SI = (raw − zero) · one.
struct Scale {
    const char *unit;
    std::string format; // "Q15 of I_b = 40 A"
    double one;
    double zero;
};
// Of a word.
Scale word_scale(const SignalInfo &signal, const Simulation &sim);
const char *home_text(Word::Home home);

// NaN where nobody knows it: what the motor does in a recording, and the drive's estimate while its
// gates are open.
double si_value(const SignalInfo &signal, const Tick &tick);
// Whether the tick has it, be it known to the drive at this instant or not: what the motor does is
// not in a recording.
bool is_told(const SignalInfo &signal, const Tick &tick);
std::optional<int64_t> raw_value(const SignalInfo &signal, const Tick &tick);
// What a recording has of it: of the drive's outputs, in a run of a recording.
std::optional<int64_t> recorded_value(const SignalInfo &signal, const Tick &tick);

// "A", or "" for a number.
const char *unit_text(const SignalInfo &signal, const Simulation &sim);
// "Q15 of I_b = 40 A", or "" where there is no raw value.
std::string format_text(const SignalInfo &signal, const Simulation &sim);
// A value of a signal that is a word (RUN, OVERCURRENT), else empty.
std::string word_text(const SignalInfo &signal, int64_t raw);

struct RawRange {
    int64_t lowest;
    int64_t highest;
};
// What a word can hold.
RawRange raw_range(const Word &word);
// The raw value that comes nearest to an SI value; it may be out of range.
double raw_from_si(const SignalInfo &signal, double si, const Simulation &sim);
// Writes a word of the drive's state or configuration; `raw` within its range.
void write_word(const Word &word, int64_t raw, const Seam &seam);

} // namespace nf
