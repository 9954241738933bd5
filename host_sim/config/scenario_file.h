/* SPDX-License-Identifier: MIT */
// The parts of a scenario file that are no single settings: its lists and the accepted limits.
#pragma once

#include "layer.h"

namespace nf
{

// The keys of [scenario] that hold a list of tables.
const std::vector<std::string> &scenario_lists();

// Checks them on their own, with the mode that the file itself states.
void check_scenario(const Layer &layer);

// Puts those of all layers, the first one first, into the configuration, whose settings are final:
// motor and mode are needed. Notes in it what will not happen as written.
void apply_scenario(const std::vector<const Layer *> &layers, Config &config);

} // namespace nf
