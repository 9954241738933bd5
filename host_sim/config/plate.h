/* SPDX-License-Identifier: MIT */
// A motor of which only the name plate is known: what a user has to say before the drive can
// measure the rest.
//
//   the plate says     name, pole_pairs, max_speed_rpm, max_current_a, continuous_current_a, and
//                      the sensor of the shaft
//   it does not say    resistance_ohm, inductance_d_h, inductance_q_h, flux_linkage_wb,
//                      rated_torque_nm, rated_speed_rpm, inertia_kg_m2, viscous_friction_nm_s:
//                      these are 0 in its settings
//
// The file is read by load_plate() of config.h.
#pragma once

#include "configuration.h"

#include <string>
#include <vector>

namespace nf
{

// The keys of [motor] that a name plate does not say, "motor.resistance_ohm" first. A file that
// lacks all of them is a name plate; viscous_friction_nm_s, the last one, may stand in it and is
// ignored.
const std::vector<std::string> &unknown_of_plate();

// Whether all is 0 that a name plate does not say. In a motor that has been read, no such value but
// the friction is 0.
bool is_plate(const MotorSettings &motor);

// The name plate of a motor: what it does not say is 0. continuous_current_a is what the drive
// takes for it: the motor's, else that of rated torque, and at most max_current_a. Of a name plate
// the same name plate.
MotorSettings plate_of(const MotorSettings &motor);

// A name plate with typical values for the rest: those of a motor of the zoo that makes the most of
// this bus. With ω the electrical speed at max_speed_rpm, I the continuous current, P the pole
// pairs:
//
//   rated speed    max_speed_rpm
//   φ              0.6·bus_nominal_v/√3 over ω
//   rated torque   1.5·P·φ·I
//   R              0.15·(p/100 W)^−0.35 of the EMF over I, p = 1.5·EMF·I; at most what the
//                  firmware's format holds
//   L_d = L_q      0.13 of the EMF over ω·I
//   J              0.1 s from rest to rated speed with rated torque
//   friction       0.02 of rated torque at rated speed
//
// Each is kept within the range of its key. Total for a plate and a board within the ranges of
// their keys, with a continuous current above 0; what the plate holds of the unknown is ignored.
// The real motor may differ by a factor of ten in R, L and J, so this is where a measurement
// starts, and no value to control a motor with.
MotorSettings typical(const MotorSettings &plate, const BoardSettings &board);

// What a drive knows of a configuration's motor that it has not measured: the name plate, and no
// factor of [model].
Config known_from_plate(const Config &config);

// The configuration of a name plate as build() takes it: `motor` is typical(). Hall sensors are
// read whatever drive.angle_source says, so that they can be measured. A message about such
// a value says "FILE (typical value)" for its place.
Config with_typical(const Config &plate);

} // namespace nf
