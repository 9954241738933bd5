/* SPDX-License-Identifier: MIT */
// Keys that somebody writes and that do nothing in this configuration.
#pragma once

#include "layer.h"

#include <vector>

namespace nf
{

// Notes a line in config.scenario.notes for each key of these layers that is in force and does not
// act.
void note_idle(const std::vector<const Layer *> &layers, Config &config);

} // namespace nf
