/* SPDX-License-Identifier: MIT */
// Inertia from the impulse of torque that changes the speed, and friction from what holds it.
//
// A ramp between two speeds with the mean torque τ in a time t, τ_f the torque that holds the mean speed of it, straight
// between those that hold both speeds:
//
//   J·(ω_2 − ω_1)/P = (τ − τ_f)·t
//
// What τ_f lacks has the same sign up and down, and cancels in the mean of both.
#pragma once

#include "turning.h"

namespace nf::identify
{

// Up and down, the mean of each pair of the steepest ramps. Throws std::runtime_error where there is no pair.
Estimate fit_inertia(const Records &records);

// Torque that turns against the motion: coulomb_nm + viscous_nm_s·ω, ω mechanical.
struct Friction {
    Estimate coulomb_nm;
    Estimate viscous_nm_s;
};

// From how the speed of a rotor that coasts falls, in windows that the frame has followed; there are at least four of them.
Friction coasting_friction(const std::vector<Window> &windows, const Scales &scales,
                           const Estimate &inertia);

// From the torque that holds a speed, with windows at two speeds.
Friction holding_friction(const Records &records, const Legs &legs);

} // namespace nf::identify
