/* SPDX-License-Identifier: MIT */
// A certificate as a table for a person at a terminal.
#pragma once

#include "judge.h"

#include <string>

namespace nf::certify
{

std::string text_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
