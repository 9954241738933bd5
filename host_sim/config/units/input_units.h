/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the input that commands the drive without a PC.
#pragma once

#include "bases.h"

namespace nf
{

input_cfg_t make_input(const InputSettings &input, const Bases &b);

} // namespace nf
