/* SPDX-License-Identifier: MIT */
// The files of a motor of the zoo, as a user would write them.
#pragma once

#include "reference.h"

#include <string>
#include <vector>

namespace nf::zoo
{

// What a scenario's file calls the others.
struct Names {
    std::string motor;
    std::string board;
    std::string exact; // the scenario that the user's is based on
};

// The text of each file, TOML in SI units.
std::string motor_file(const Reference &reference);
std::string board_file(const Reference &reference);
// Start, 55 % and 100 % of rated speed, half of the rated torque on and off, standstill, −10 %: the
// real motor is what its file says, or a user's, which differs from it.
std::string scenario_file(const Reference &reference, const Names &names);
// All of them under their names, motor.toml, board.toml, exact.toml and user.toml, which refer to
// each other.
struct File {
    const char *name;
    std::string text;
};
std::vector<File> files(const Reference &reference);
// What a user's motor and board differ by, as a set of imperfections.
std::string imperfection_file(const Reference &reference);

} // namespace nf::zoo
