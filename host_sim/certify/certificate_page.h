/* SPDX-License-Identifier: MIT */
// A certificate as one page of HTML with a map. It needs no other file and asks for nothing
// elsewhere.
#pragma once

#include "judge.h"

#include <string>

namespace nf::certify
{

std::string page_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
