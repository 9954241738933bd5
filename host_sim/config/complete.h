/* SPDX-License-Identifier: MIT */
// Whether the files of a configuration say all that they have to. All throw ConfigError with one
// line for all that is missing, at the table of the first.
#pragma once

#include "configuration.h"
#include "layer.h"

namespace nf
{

// Every required setting of the sections that `home`, a file of this kind, is there for has to be
// in the configuration. Of a motor file that is a name plate the line says so.
void check_complete(FileKind kind, const Layer &home, const Config &config);

// The motor file `home` has to be complete, or a name plate (plate.h) with all that it is asked
// for.
void check_plate(const Layer &home, const Config &config);

// Reduces the motor to its name plate and drops [measured], so that values that are to be measured
// count as not given. Where the continuous current follows from the rated torque, a message about
// it names the line of that torque.
void forget_measured(Config &config);

} // namespace nf
