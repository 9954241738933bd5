// SPDX-License-Identifier: MIT
#include "table.h"

#include "signals.h"
#include "stages.h"

#include <nlohmann/json.hpp>

namespace nf::debug
{
namespace
{

using Json = nlohmann::ordered_json;

Json words(const Simulation &sim)
{
    Json all = Json::array();
    for (const SignalInfo &signal : all_signals()) {
        if (signal.value == nullptr) {
            const Scale scale = word_scale(signal, sim);
            all.push_back({{"name", signal.name},
                           {"home", home_text(signal.word.home)},
                           {"member", signal.word.member},
                           {"unit", scale.unit},
                           {"format", scale.format},
                           {"one", scale.one},
                           {"zero", scale.zero}});
        }
    }
    return all;
}

// Only words: what is computed of a run as a whole is not in the firmware's memory.
Json stages()
{
    Json all = Json::array();
    for (const Stage &stage : all_stages()) {
        Json names = Json::array();
        for (const char *const name : stage.signals) {
            if (find_signal(name)->value == nullptr) {
                names.push_back(name);
            }
        }
        if (names.empty()) {
            continue;
        }
        Json one = {{"title", stage.title}, {"signals", names}};
        if (stage.flag != nullptr) {
            one["flag"] = stage.flag;
            one["shown_with"] = stage.shown_with;
        }
        if (!stage.states.empty()) {
            one["states"] = stage.states;
        }
        all.push_back(one);
    }
    return all;
}

} // namespace

std::string table_json(const Config &config)
{
    const Simulation sim(config);
    const Bases &bases = sim.bases();
    const Json table = {
        {"scenario", config.scenario.id},
        {"crc", sim.cfg().crc},
        {"bases",
         {{"control_period_s", bases.control_period_s},
          {"current_a", bases.current_a},
          {"voltage_v", bases.voltage_v},
          {"pole_pairs", bases.pole_pairs}}},
        {"words", words(sim)},
        {"stages", stages()},
    };
    return table.dump(1) + '\n';
}

} // namespace nf::debug
