/* SPDX-License-Identifier: MIT */
// What a certificate says in words, the same at a terminal and on the page.
#pragma once

#include "judge.h"

#include <string>

namespace nf::certify
{

// The motor on the board.
std::string head_of(const Campaign &campaign);

// How many of the machines are locked, and how sure that is.
std::string result_of(const Campaign &campaign, const Judgement &judgement);

// Up to which load all machines hold, and which value limits most with the way to know it better.
std::string limit_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
