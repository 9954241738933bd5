// SPDX-License-Identifier: MIT
#include "layer.h"

namespace nf
{

void apply_layer(const Layer &layer, Config &config)
{
    for (const Setting &setting : layer.settings) {
        apply_value(*setting.field, setting.value, config);
    }
}

} // namespace nf
