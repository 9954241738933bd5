// SPDX-License-Identifier: MIT
#include "vcd.h"

#include "names.h"

extern "C" {
#include "fault_text.h"
#include "transitions.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace nf
{
namespace
{

constexpr double NS_PER_S = 1e9;
constexpr unsigned STATE_BITS = 8;

// What is written of each tick.
constexpr std::array<const char *, 22> SIGNALS = {
    "state",
    "fault",
    "speed_command_rpm",
    "speed_rpm",
    "speed_estimated_rpm",
    "speed_reference_rpm",
    "angle_error_el_deg",
    "i_q_a",
    "i_q_estimated_a",
    "i_q_reference_a",
    "i_d_a",
    "i_d_estimated_a",
    "i_a_a",
    "i_b_a",
    "i_c_a",
    "v_d_v",
    "v_q_v",
    "duty_a",
    "duty_b",
    "duty_c",
    "bus_v",
    "torque_nm",
};

bool is_enumeration(const SignalInfo &signal)
{
    return signal.quantity == Quantity::state || signal.quantity == Quantity::fault;
}

// Printable characters, as the format wants its identifiers.
std::string identifier(std::size_t number)
{
    return std::string(1, static_cast<char>('!' + number));
}

std::string binary(unsigned value)
{
    std::string digits = "b";
    for (unsigned bit = STATE_BITS; bit-- > 0;) {
        digits += ((value >> bit) & 1U) != 0 ? '1' : '0';
    }
    return digits;
}

// The numbers of states and faults.
std::string legend()
{
    std::string text = "state:";
    for (uint32_t number = 0; number < DRIVE_STATES; number++) {
        const drive_state_t state = transitions_state(number);
        text += fmt::format(" {}={}", static_cast<int>(state), state_name(state));
    }
    text += "; fault:";
    for (int id = FAULT_NONE; id < FAULT_COUNT; id++) {
        text += fmt::format(" {}={}", id, fault_text(static_cast<fault_id_t>(id))->name);
    }
    return text;
}

} // namespace

Vcd::Vcd(const std::string &path, const TimeWindow &window)
    : path_(path), window_(window), file_(path)
{
    std::size_t number = 0;
    for (const char *const name : SIGNALS) {
        variables_.push_back({find_signal(name), identifier(number++), ""});
    }
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        for (const bool high : {true, false}) {
            const std::string name =
                fmt::format("gate_{}_{}", static_cast<char>('a' + leg), high ? "high" : "low");
            switches_.push_back({name, identifier(number++), leg, high, std::nullopt});
        }
    }
}

void Vcd::declare()
{
    const auto out = std::back_inserter(buffer_);
    fmt::format_to(
        out,
        "$version motorsim $end\n$timescale 1 ns $end\n$comment time 0 is t = {:g} s; {} $end\n",
        std::min(window_.from_s, 0.0), legend());
    declare_variables();
    fmt::format_to(out, "$enddefinitions $end\n");
    declared_ = true;
}

void Vcd::declare_variables()
{
    const auto out = std::back_inserter(buffer_);
    fmt::format_to(out, "$scope module drive $end\n");
    for (const Variable &variable : variables_) {
        const bool enumeration = is_enumeration(*variable.signal);
        fmt::format_to(out, "$var {} {} {} {} $end\n", enumeration ? "reg" : "real",
                       enumeration ? STATE_BITS : 64U, variable.id, variable.signal->name);
    }
    fmt::format_to(out, "$upscope $end\n$scope module inverter $end\n");
    for (const Switch &one : switches_) {
        fmt::format_to(out, "$var wire 1 {} {} $end\n", one.id, one.name);
    }
    fmt::format_to(out, "$upscope $end\n");
}

void Vcd::move_to(double time_s)
{
    const auto time_ns =
        static_cast<int64_t>(std::llround((time_s - std::min(window_.from_s, 0.0)) * NS_PER_S));
    if (!time_ns_ || time_ns > *time_ns_) {
        fmt::format_to(std::back_inserter(buffer_), "#{}\n", time_ns);
        time_ns_ = time_ns;
    }
}

void Vcd::write_signals(const Tick &tick)
{
    const auto out = std::back_inserter(buffer_);
    move_to(tick.time_s);
    for (Variable &variable : variables_) {
        const double value = si_value(*variable.signal, tick) + 0.0; // −0 is no change from 0
        const std::string text = is_enumeration(*variable.signal)
                                     ? binary(static_cast<unsigned>(value))
                                     : fmt::format("r{:.9g}", value);
        if (text != variable.last) {
            fmt::format_to(out, "{} {}\n", text, variable.id);
            variable.last = text;
        }
    }
}

void Vcd::write_switches(double time_s, unsigned high, unsigned low)
{
    for (Switch &one : switches_) {
        const bool closed = (((one.high ? high : low) >> one.leg) & 1U) != 0;
        if (!one.last || closed != *one.last) {
            move_to(time_s);
            fmt::format_to(std::back_inserter(buffer_), "{:d}{}\n", closed, one.id);
            one.last = closed;
        }
    }
}

// The period that begins now, on a copy of the inverter's timing.
void Vcd::write_pattern(const Tick &tick)
{
    const plant_t &plant = tick.sim->plant();
    plant_inverter_t inverter = plant.inverter;
    plant_pattern_t pattern;
    if (plant.gates_on) {
        plant_inverter_pattern(&inverter, plant.compare, &pattern);
    } else {
        plant_inverter_off(&inverter, &pattern);
    }
    double time_s = tick.time_s;
    for (unsigned k = 0; k < pattern.count; k++) {
        const plant_segment_t &segment = pattern.segment[k];
        write_switches(time_s, segment.high, segment.low);
        time_s += segment.duration_s;
    }
}

void Vcd::add(const Tick &tick)
{
    const double half_tick_s = tick.sim->bases().control_period_s / 2;
    const bool inside =
        tick.time_s > window_.from_s - half_tick_s && tick.time_s < window_.to_s + half_tick_s;
    if (!inside) {
        return;
    }
    if (!declared_) {
        declare();
    }
    write_signals(tick);
    write_pattern(tick);
    end_s_ = tick.time_s + tick.sim->bases().control_period_s;
    if (buffer_.size() > OutputFile::WORTH_WRITING) {
        flush();
    }
}

void Vcd::flush()
{
    file_.write({buffer_.data(), buffer_.size()});
    buffer_.clear();
}

void Vcd::close()
{
    if (!declared_) {
        throw VcdError(fmt::format("{}: no tick of the run is from t = {:g} s to {:g} s", path_,
                                   window_.from_s, window_.to_s));
    }
    move_to(end_s_);
    flush();
    file_.close();
}

} // namespace nf
