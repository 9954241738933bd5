/* SPDX-License-Identifier: MIT */
// The identification as it runs on a board, here on the simulated one: the lines that its console would send.
#pragma once

#include "sim.h"

#include <functional>
#include <string>
#include <vector>

namespace nf::identify
{

struct Measurement {
    std::vector<std::string> lines; // records of firmware/app/identify.h
    std::string refusal;            // empty: it went to its end
    double duration_s = 0;
};

Measurement measure(Simulation &sim, const std::function<void(const Simulation &)> &each = {});

} // namespace nf::identify
