/* SPDX-License-Identifier: MIT */
// The signals of a part of a run as a value change dump (IEEE 1364), for GTKWave, Surfer and the
// like.
//
// The numbers of the trace as reals and the states as integers, changing at the tick's instant; the
// six switches of the inverter as wires, changing when they do: at the edges of the PWM pattern,
// dead time included, in steps of 1 ns. Time 0 is t = 0 of the scenario, or the beginning of the
// window where that is earlier. A comparator of the power stage that opens the gates within a
// period shows at the end of it.
#pragma once

#include "output_file.h"
#include "signals.h"
#include "tick.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace nf
{

// what() is the complete line for the user.
struct VcdError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct TimeWindow {
    double from_s;
    double to_s; // of the last tick
};

class Vcd : public TickSink
{
public:
    // All of it throws OutputError.
    Vcd(const std::string &path, const TimeWindow &window);

    void add(const Tick &tick) override;
    // Call after the last tick; without, there is no file. Throws VcdError when no tick was in the
    // window.
    void close();

private:
    struct Variable {
        const SignalInfo *signal;
        std::string id;
        std::string last; // as written
    };
    struct Switch {
        std::string name;
        std::string id;
        unsigned leg;
        bool high;
        std::optional<bool> last;
    };

    void declare();
    void declare_variables();
    void write_signals(const Tick &tick);
    void write_pattern(const Tick &tick);
    void write_switches(double time_s, unsigned high, unsigned low);
    void move_to(double time_s);
    void flush();

    std::string path_;
    TimeWindow window_;
    OutputFile file_;
    fmt::memory_buffer buffer_;
    std::vector<Variable> variables_;
    std::vector<Switch> switches_;
    double end_s_ = 0; // of the last period written
    bool declared_ = false;
    std::optional<int64_t> time_ns_;
};

} // namespace nf
