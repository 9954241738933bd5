/* SPDX-License-Identifier: MIT */
// How the signals of a board get to its chip, an STM32G431: shunts, amplifiers, comparators.
#pragma once

#include "specimen.h"

namespace nf::zoo
{

struct Binding {
    double sampling_s = 0;
    bool falls = false; // the comparators trip below their level
    double shunt_ohm = 0;
    double amplifier_gain = 0;
    double amplifier_zero_v = 0;
    int pga_gain = 0;
    double adc_reference_v = 0;
    double bus_divider = 0;
};

Binding draw_binding(const Draw &draw, const Specimen &specimen);

} // namespace nf::zoo
