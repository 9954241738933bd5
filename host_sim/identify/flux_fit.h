/* SPDX-License-Identifier: MIT */
// Flux linkage of the magnet, two ways: from the voltage of a current that turns the rotor, and from that of a rotor that
// coasts without current.
//
// With current, an error of L_d counts as flux in proportion to the current: φ + ε·I. Windows with the whole and the half of
// the current tell both apart as far as ε is not known better from L_d itself.
#pragma once

#include "turning.h"

#include <optional>

namespace nf::identify
{

struct Flux {
    Estimate magnet_wb; // of both ways by the weight of their bars, if they agree; else as turning
    Estimate turning_wb;
    std::optional<Estimate> coasting_wb; // none where the rotor was lost at once
    double highest_rad_s = 0; // electrical
};

// Whether two estimates of one value differ by no more than their bars together.
bool agree(const Estimate &one, const Estimate &other);

// The windows of kind "coast" in which the frame has followed the rotor: |v|/ω within 10 % of φ.
std::vector<Window> followed(const Records &records, const LegModel &legs, double flux_wb);

// From windows of the kinds "spin", "hold" and "coast". Throws std::runtime_error where no window turns.
Flux fit_flux(const Records &records, const Legs &legs, const Inductances &inductances);

} // namespace nf::identify
