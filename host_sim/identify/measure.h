/* SPDX-License-Identifier: MIT */
// The identification as it runs on a board, here on the simulated one.
#pragma once

#include "sim.h"

#include <functional>
#include <string>
#include <vector>

namespace nf::identify
{

struct Measurement {
    std::vector<std::string> lines; // what the console of a board would send
    std::string refusal;            // why it has not come to its end; empty: it has
    double duration_s = 0;
};

// Of each line as it is sent.
using Listener = std::function<void(const std::string &)>;
// Before each control tick: what happens to the machine.
using Event = std::function<void(Simulation &)>;

// Runs it to its end on the motor of `sim`, from power-up on. It ends by itself within 2 minutes
// after its start; a drive that has a fault before is refused with the fault's name, and one that
// has not ended after 130 s is refused too.
Measurement measure(Simulation &sim, const Listener &listener = {}, const Event &event = {});

} // namespace nf::identify
