/* SPDX-License-Identifier: MIT */
// A certificate as a table for a person at a terminal.
#pragma once

#include "judge.h"

#include <string>

namespace nf::certify
{

std::string text_of(const Campaign &campaign, const Judgement &judgement);

// What stands at the head of each form: the motor on the board.
std::string head_of(const Campaign &campaign);

// Says how many of which runs are locked, in one sentence.
std::string result_of(const Campaign &campaign, const Judgement &judgement);

// What limits most and how to know it better, and up to which load all machines hold: a sentence or two each.
std::string limit_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
