// SPDX-License-Identifier: MIT
#include "extremes.h"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

namespace nf
{
namespace
{

constexpr std::array<const char *, 9> INTERMEDIATES = {
    "drive.bus",
    "drive.control.current_ref.d",
    "drive.control.current_ref.q",
    "drive.control.voltage.d",
    "drive.control.voltage.q",
    "drive.control.ratio_next.alpha",
    "drive.control.ratio_next.beta",
    "drive.control.ratio_acting.alpha",
    "drive.control.ratio_acting.beta",
};

bool is_intermediate(const SignalInfo &signal)
{
    const std::string name = signal.name;
    return name.rfind("out.", 0) == 0 ||
           std::find(INTERMEDIATES.begin(), INTERMEDIATES.end(), name) != INTERMEDIATES.end();
}

} // namespace

Extremes::Extremes()
{
    for (const SignalInfo &signal : all_signals()) {
        if (is_intermediate(signal)) {
            seen_.push_back({&signal});
        }
    }
}

void Extremes::add(const Tick &tick)
{
    for (Seen &seen : seen_) {
        const int64_t raw = raw_value(*seen.signal, tick).value_or(0);
        if (seen.lowest > seen.highest) { // the scales are those of the run
            seen.scale = word_scale(*seen.signal, *tick.sim);
        }
        seen.lowest = std::min(seen.lowest, raw);
        seen.highest = std::max(seen.highest, raw);
    }
}

std::string Extremes::json_text() const
{
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const Seen &seen : seen_) {
        all.push_back({{"name", seen.signal->name},
                       {"min", seen.lowest},
                       {"max", seen.highest},
                       {"unit", seen.scale.unit},
                       {"one", seen.scale.one},
                       {"zero", seen.scale.zero}});
    }
    return all.dump(1) + '\n';
}

} // namespace nf
