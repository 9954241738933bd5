// SPDX-License-Identifier: MIT
#include "vocabulary.h"

#include "ends_with.h"
#include "names.h"
#include "readable.h"

extern "C" {
#include "fault_text.h"
#include "transitions.h"
}

#include <map>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

constexpr std::size_t NEAR_SIGNALS = 5;
const std::string RAW = ".raw";

const std::map<std::string, int> &enumerators()
{
    static const std::map<std::string, int> table = [] {
        std::map<std::string, int> found;
        for (uint32_t number = 0; number < DRIVE_STATES; number++) {
            const drive_state_t state = transitions_state(number);
            found.emplace(state_name(state), state);
        }
        for (int id = FAULT_NONE; id < FAULT_COUNT; id++) {
            found.emplace(fault_text(static_cast<fault_id_t>(id))->name, id);
        }
        return found;
    }();
    return table;
}

std::string unknown_text(const std::string &name)
{
    std::string line = fmt::format("there is no signal {}", readable(name));
    const std::vector<std::string> near = near_signals(name, NEAR_SIGNALS);
    if (near.empty()) {
        return line + "; `signals` lists them";
    }
    line += "; near:";
    for (const std::string &other : near) {
        line += ' ' + other;
    }
    return line + "; `signals` lists all";
}

std::string recorded_text(const SignalInfo &signal, int64_t raw, const Tick &tick)
{
    const std::optional<int64_t> recorded = recorded_value(signal, tick);
    return recorded ? fmt::format("  recorded {}{}", *recorded, *recorded == raw ? "" : " *") : "";
}

} // namespace

Named named_signal(const std::string &name)
{
    const bool raw = ends_with(name, RAW);
    const std::string plain = raw ? name.substr(0, name.size() - RAW.size()) : name;
    const SignalInfo *const signal = find_signal(plain);
    if (signal == nullptr) {
        throw std::runtime_error(unknown_text(plain));
    }
    if (raw && signal->value != nullptr) {
        throw std::runtime_error(fmt::format("{} has no raw value", plain));
    }
    return {signal, raw};
}

Value named_value(const std::string &name)
{
    const auto found = enumerators().find(name);
    if (found != enumerators().end()) {
        return [value = static_cast<double>(found->second)](const Tick &) { return value; };
    }
    const Named named = named_signal(name);
    if (named.raw) {
        return [signal = named.signal](const Tick &tick) {
            return static_cast<double>(raw_value(*signal, tick).value_or(0));
        };
    }
    return [signal = named.signal](const Tick &tick) { return si_value(*signal, tick); };
}

std::string signal_line(const Named &named, const Tick &tick)
{
    constexpr int NAME_WIDTH = 35; // longer ones push the rest to the right
    constexpr int VALUE_WIDTH = 19;
    const SignalInfo &signal = *named.signal;
    const std::optional<int64_t> raw = raw_value(signal, tick);
    const std::string word = raw ? word_text(signal, *raw) : "";
    const std::string si = word.empty() ? fmt::format("{:.6g} {}", si_value(signal, tick),
                                                      unit_text(signal, *tick.sim))
                                        : word;
    if (!raw) {
        return fmt::format("{:<{}} {}", signal.name, NAME_WIDTH, si);
    }
    return fmt::format("{:<{}} {:<{}} raw {:<11} {}", signal.name, NAME_WIDTH, si, VALUE_WIDTH,
                       *raw, format_text(signal, *tick.sim)) +
           recorded_text(signal, *raw, tick);
}

const std::vector<std::string> &all_words()
{
    static const std::vector<std::string> words = [] {
        std::vector<std::string> all;
        for (const SignalInfo &signal : all_signals()) {
            all.emplace_back(signal.name);
        }
        for (const auto &[name, number] : enumerators()) {
            all.push_back(name);
        }
        return all;
    }();
    return words;
}

} // namespace nf::debug
