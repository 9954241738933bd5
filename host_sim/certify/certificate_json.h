/* SPDX-License-Identifier: MIT */
// A certificate for programs.
#pragma once

#include "judge.h"

#include <string>

namespace nf::certify
{

// One object: the motor and the board, the box, each tuning with its counts, margins and
// influences, what is recommended and why, and each run of the recommended tuning with its draw.
// The same campaign gives the same bytes.
std::string json_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
