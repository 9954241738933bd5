// SPDX-License-Identifier: MIT
#include "idle.h"

#include <set>

#include <fmt/format.h>

namespace nf
{

void note_idle(const std::vector<const Layer *> &layers, Config &config)
{
    std::set<const Field *> written;
    for (const Layer *layer : layers) {
        for (const Setting &setting : layer->settings) {
            written.insert(setting.field);
        }
    }
    for (const Field &field : schema()) {
        const auto origin = config.origins.find(field.name());
        if (written.count(&field) != 0 && origin != config.origins.end() &&
            !field.acting.holds(config)) {
            config.scenario.notes.push_back(
                fmt::format("{}: {} = {}: acts {}", origin->second.text(), field.name(),
                            field.value_text(config), field.acting.when));
        }
    }
}

} // namespace nf
